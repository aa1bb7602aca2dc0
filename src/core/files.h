#pragma once
#include "core/memory.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// Bytes that a file's are read into.
using FileBytes = std::vector<std::byte, UninitializedAllocator<std::byte>>;

/// The whole file. Throws Error if it is missing, unreadable or not a regular file, LimitError if
/// it is larger than `max_bytes`.
FileBytes read_file(const std::string& path, uint64_t max_bytes);

/// The same for a file that is open for reading; closes it. `path` is for messages.
FileBytes read_open_file(int fd, const std::string& path, uint64_t max_bytes);

/// All that standard input gives. Throws Error, LimitError if it is more than `max_bytes`.
FileBytes read_standard_input(uint64_t max_bytes);

/// Writes all of `data`, at the current position or at `offset`, and resumes after signals. Returns
/// false with errno set on failure.
bool write_all(int fd, std::span<const std::byte> data, std::optional<uint64_t> offset = {});

/// The path's extension in lower case, with its dot; empty if there is none.
std::string extension_of(const std::string& path);

/// Whether `path`, which need not exist, is `folder` or inside it after resolving symbolic links.
/// Throws std::filesystem::filesystem_error.
bool is_within(const std::string& path, const std::string& folder);

/// The prefix of temporary files' names; files with it that a power cut left may be removed.
inline constexpr const char* temporary_prefix = ".sightline-";

/// A unique path with a random name in the folder of `path`.
std::string temporary_for(const std::string& path);

/// Whether files are synced to the disk before they replace others (default: yes). Without syncing,
/// a power cut may leave them empty: for processes whose files another process syncs.
void sync_files(bool on);

/// Waits until the files are on the disk. Throws Error.
void sync_to_disk(const std::vector<std::string>& paths);

/// The file that writing to `path` creates or replaces, with symbolic links resolved. Throws Error
/// if it exists and is not a regular file.
std::string write_target(const std::string& path);

/// A file that replaces `path` on commit: readers see either the old file or the complete new one.
/// If the file system allows, it has no name until then, so nothing is left if the process is
/// killed.
class PendingFile {
  public:
    /// Throws Error as write_target does, and if no file can be created in the folder.
    explicit PendingFile(const std::string& path);
    /// Discards the file unless it has been committed.
    ~PendingFile();
    PendingFile(const PendingFile&) = delete;

    /// The path to open for writing.
    const std::string& writable_path() const { return writable_path_; }

    /// Writes all of `data` at the file's current position. Throws Error.
    void write(std::span<const std::byte> data);

    /// Syncs the file and moves it to `path` or, if given, to `other`, a path in the same folder.
    /// Throws Error.
    void commit();
    void commit(const std::string& other);

  private:
    std::string path_, temporary_, writable_path_;
    int fd_ = -1;
    bool named_ = false;  // `temporary_` exists and must be removed
};

/// Calls `write` with the writable path of a pending file for `path`, then commits it. On failure
/// no file is left and the exception propagates.
void write_atomically(const std::string& path,
                      const std::function<void(const std::string& temporary)>& write);

/// Writes `data` to `path` atomically. Throws Error.
void write_file(const std::string& path, std::span<const std::byte> data);
void write_text(const std::string& path, std::string_view text);

}  // namespace sightline
