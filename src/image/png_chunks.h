#pragma once
// A guard in front of libpng, which would print messages about damaged chunks itself.
#include <cstddef>
#include <span>
#include <string>

namespace sightline {

/// Throws Error with the chunk and its offset if a PNG's chunks are truncated or have wrong
/// checksums. `name` is for messages.
void check_png_chunks(std::span<const std::byte> file, const std::string& name);

}  // namespace sightline
