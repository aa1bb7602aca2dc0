#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// The whole file. Throws Error: missing, unreadable, a directory, or larger than `max_bytes`.
std::vector<std::byte> read_file(const std::string& path, uint64_t max_bytes);

/// How the names of temporaries begin: what is left of them after a power cut may be removed.
inline constexpr const char* temporary_prefix = ".sightline-";

/// A path in the folder of `path` that nobody else uses, of a random name.
std::string temporary_for(const std::string& path);

/// Whether files wait for the disk before they take their place (at first: yes). Without, a
/// power cut may leave them empty: for a process whose files somebody else syncs.
void sync_files(bool on);

/// Waits until the files are on the disk. Throws Error.
void sync_to_disk(const std::vector<std::string>& paths);

/// The file that writing to `path` makes or replaces: where links lead. Throws Error where a
/// folder, a device or a pipe stands there, which nobody means to replace.
std::string write_target(const std::string& path);

/// A file in the making, which takes the place of `path` once it is whole: readers see the old
/// file or the whole new one. Where the file system allows it has no name until then, so that
/// nothing is left of it even if the process is killed.
class PendingFile {
  public:
    /// Throws Error as write_target, and where none can be made in the folder.
    explicit PendingFile(const std::string& path);
    /// Without a commit nothing is left.
    ~PendingFile();
    PendingFile(const PendingFile&) = delete;

    /// What to open for writing.
    const std::string& place() const { return place_; }

    /// Syncs it and puts it at `path`. Throws Error.
    void commit();

  private:
    std::string path_, temporary_, place_;
    int fd_ = -1;
    bool named_ = false;  // there is a temporary that must go
};

/// Calls `write` with the place of a pending file for `path`, then commits it. On any failure
/// nothing is left and the exception goes on.
void write_atomically(const std::string& path,
                      const std::function<void(const std::string& temporary)>& write);

/// Writes `data` to `path`, whole or not at all. Throws Error.
void write_file(const std::string& path, std::span<const std::byte> data);
void write_text(const std::string& path, std::string_view text);

}  // namespace sightline
