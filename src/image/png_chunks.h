#pragma once
#include <cstddef>
#include <span>
#include <string>

namespace sightline {

/// Throws Error, with the chunk and its place, where a PNG's chunks are cut off or their checksums
/// do not fit. `name` is for messages.
void check_png_chunks(std::span<const std::byte> file, const std::string& name);

}  // namespace sightline
