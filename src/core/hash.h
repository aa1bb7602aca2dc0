#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace sightline {

/// XXH3 of the bytes, 64 bits: finds changes, not forgeries. `seed` chains several pieces.
uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed = 0);

/// The same of a text.
uint64_t hash_text(const std::string& text, uint64_t seed = 0);

/// Hash of a regular file's content, whatever its size. Throws Error.
uint64_t hash_file(const std::string& path);

}  // namespace sightline
