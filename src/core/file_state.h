#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace sightline {

/// What changes if a file is written or replaced; times in nanoseconds since 1970.
struct FileState {
    uint64_t device = 0, inode = 0, size = 0;
    int64_t modified = 0, changed = 0;  ///< of the content, of the inode
    bool operator==(const FileState&) const = default;
};

/// The file's state, links followed; none if it does not exist.
std::optional<FileState> state_of_file(const std::string& path);

/// Whether a write after `time`, in nanoseconds since 1970, gives the file another state: its times
/// lie more than two seconds before, the coarsest step in which a file system keeps them.
bool is_settled(const FileState& state, int64_t time);

/// Nanoseconds since 1970.
int64_t nanoseconds_now();

}  // namespace sightline
