#include "core/files.h"

#include "core/descriptor.h"
#include "core/error.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>

namespace sightline {
namespace {

[[noreturn]] void fail(const std::string& path, const char* what) {
    throw Error(fmt::format("{}: {}: {}", path, what, std::strerror(errno)));
}

std::string folder_of(const std::string& path) {
    const std::string folder = std::filesystem::path(path).parent_path();
    return folder.empty() ? "." : folder;
}

bool files_are_synced = true;

}  // namespace

// The name is short because the target's may already be as long as the file system allows, and
// random because another machine may write to the same folder.
std::string temporary_for(const std::string& path) {
    uint64_t random = 0;
    if (getrandom(&random, sizeof random, 0) != sizeof random) fail(path, "no random number");
    return std::filesystem::path(path).replace_filename(
        fmt::format("{}{:016x}", temporary_prefix, random));
}

void sync_files(bool on) { files_are_synced = on; }

void sync_to_disk(const std::vector<std::string>& paths) {
    std::vector<std::unique_ptr<Descriptor>> files;
    for (const std::string& path : paths) {
        files.push_back(std::make_unique<Descriptor>(open(path.c_str(), O_RDONLY | O_CLOEXEC)));
        if (files.back()->get() < 0) fail(path, "cannot write");
        // Start writing all files before waiting for the first.
        sync_file_range(files.back()->get(), 0, 0, SYNC_FILE_RANGE_WRITE);
    }
    for (size_t i = 0; i < paths.size(); ++i)
        if (fsync(files[i]->get()) != 0) fail(paths[i], "cannot write");
}

bool write_all(int fd, std::span<const std::byte> data, std::optional<uint64_t> offset) {
    for (size_t done = 0; done < data.size();) {
        const std::span<const std::byte> rest = data.subspan(done);
        const ssize_t wrote =
            offset ? pwrite(fd, rest.data(), rest.size(), static_cast<off_t>(*offset + done))
                   : write(fd, rest.data(), rest.size());
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote < 0) return false;
        done += static_cast<size_t>(wrote);
    }
    return true;
}

std::string extension_of(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

bool is_within(const std::string& path, const std::string& folder) {
    namespace fs = std::filesystem;
    const fs::path inner = fs::weakly_canonical(path), outer = fs::canonical(folder);
    return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first ==
           outer.end();
}

FileBytes read_file(const std::string& path, uint64_t max_bytes) {
    // O_NONBLOCK, because opening a pipe without a writer would block.
    const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) fail(path, "cannot open");
    return read_open_file(fd, path, max_bytes);
}

FileBytes read_open_file(int fd, const std::string& path, uint64_t max_bytes) {
    const Descriptor file(fd);
    struct stat status;
    if (fstat(file.get(), &status) != 0) fail(path, "cannot open");
    if (!S_ISREG(status.st_mode)) throw Error(path + ": not a regular file");
    const auto size = static_cast<uint64_t>(status.st_size);
    if (size > max_bytes)
        throw LimitError(
            fmt::format("{}: {} bytes, more than the limit of {}", path, size, max_bytes));
    FileBytes data;
    reserve_in_large_pages(data, size);
    data.resize(size);
    size_t done = 0;
    while (done < size) {
        const ssize_t got = read(file.get(), data.data() + done, size - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail(path, "cannot read");
        if (got == 0) throw Error(path + ": was truncated while being read");
        done += static_cast<size_t>(got);
    }
    return data;
}

FileBytes read_standard_input(uint64_t max_bytes) {
    constexpr size_t step = size_t{1} << 20;
    FileBytes data;
    for (size_t done = 0;;) {
        // Grows by half, so that each byte is copied a few times at most.
        if (data.size() - done < step) data.resize(data.size() + data.size() / 2 + step);
        const ssize_t got = read(STDIN_FILENO, data.data() + done, data.size() - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail("standard input", "cannot read");
        done += static_cast<size_t>(got);
        if (done > max_bytes)
            throw LimitError(
                fmt::format("standard input: more bytes than the limit of {}", max_bytes));
        if (got > 0) continue;
        data.resize(done);
        return data;
    }
}

std::string write_target(const std::string& path) {
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (fs::exists(status) && !fs::is_regular_file(status))
        throw Error(path + ": cannot write: is not a regular file");
    if (!fs::is_symlink(fs::symlink_status(path, error))) return path;
    const fs::path target = fs::weakly_canonical(path, error);
    return error ? path : target.string();
}

PendingFile::PendingFile(const std::string& path)
    : path_(write_target(path)),
      temporary_(temporary_for(path_)),
      fd_(open(folder_of(path_).c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666)) {
    writable_path_ = fmt::format("/proc/self/fd/{}", fd_);
    if (fd_ >= 0 && access(writable_path_.c_str(), W_OK) == 0) return;
    if (fd_ >= 0) close(fd_);
    fd_ = open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd_ < 0) fail(path_, "cannot write");
    named_ = true;
    writable_path_ = temporary_;
}

PendingFile::~PendingFile() {
    close(fd_);
    if (named_) unlink(temporary_.c_str());
}

void PendingFile::write(std::span<const std::byte> data) {
    if (!write_all(fd_, data)) fail(path_, "cannot write");
}

void PendingFile::commit(const std::string& other) {
    path_ = write_target(other);
    commit();
}

void PendingFile::commit() {
    if (files_are_synced && fsync(fd_) != 0) fail(path_, "cannot write");
    if (!named_) {
        if (linkat(AT_FDCWD, writable_path_.c_str(), AT_FDCWD, temporary_.c_str(),
                   AT_SYMLINK_FOLLOW) != 0)
            fail(path_, "cannot write");
        named_ = true;
    }
    if (rename(temporary_.c_str(), path_.c_str()) != 0) fail(path_, "cannot write");
    named_ = false;
    if (!files_are_synced) return;
    const Descriptor directory(open(folder_of(path_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (directory.get() >= 0) fsync(directory.get());
}

void write_atomically(const std::string& path,
                      const std::function<void(const std::string& temporary)>& write) {
    PendingFile file(path);
    write(file.writable_path());
    file.commit();
}

void write_file(const std::string& path, std::span<const std::byte> data) {
    PendingFile file(path);
    file.write(data);
    file.commit();
}

void write_text(const std::string& path, std::string_view text) {
    write_file(path, std::as_bytes(std::span(text)));
}

}  // namespace sightline
