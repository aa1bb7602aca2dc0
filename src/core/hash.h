#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace sightline {

/// The 64-bit XXH3 of the bytes: detects changes, not forgeries. `seed` chains several pieces.
uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed = 0);

/// The same for a text.
uint64_t hash_text(const std::string& text, uint64_t seed = 0);

/// The same for the contents of a regular file, which is read in pieces. Throws Error, LimitError
/// if it is larger than `max_bytes`, also by growing while it is read.
uint64_t hash_file(const std::string& path, uint64_t max_bytes = UINT64_MAX);

/// The same for a file that many tasks share: it is read again only if its inode, size or times
/// have changed since, or were younger than two seconds, so that they need not show a change.
/// Thread-safe.
uint64_t hash_shared_file(const std::string& path, uint64_t max_bytes = UINT64_MAX);

}  // namespace sightline
