#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace sightline {

/// The whole file. Throws Error: missing, unreadable, a directory, or larger than `max_bytes`.
std::vector<std::byte> read_file(const std::string& path, uint64_t max_bytes);

/// How the names of temporaries begin: what is left of them after a power cut may be removed.
inline constexpr const char* temporary_prefix = ".sightline-";

/// Calls `write` with a temporary path in the same folder, then fsyncs it and renames it to
/// `path`: readers see the old file or the whole new one. On any failure the temporary is
/// removed and the exception goes on.
void write_atomically(const std::string& path,
                      const std::function<void(const std::string& temporary)>& write);

/// Writes `data` to `path`, whole or not at all. Throws Error.
void write_file(const std::string& path, std::span<const std::byte> data);

}  // namespace sightline
