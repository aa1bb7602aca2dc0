#include "core/files.h"

#include "core/error.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace sightline {
namespace {

struct Descriptor {
    int fd;
    ~Descriptor() {
        if (fd >= 0) close(fd);
    }
};

[[noreturn]] void fail(const std::string& path, const char* what) {
    throw Error(fmt::format("{}: {}: {}", path, what, std::strerror(errno)));
}

void sync(const std::string& path) {
    const Descriptor file{open(path.c_str(), O_RDONLY | O_CLOEXEC)};
    if (file.fd < 0 || fsync(file.fd) != 0) fail(path, "cannot write");
}

}  // namespace

std::vector<std::byte> read_file(const std::string& path, uint64_t max_bytes) {
    const Descriptor file{open(path.c_str(), O_RDONLY | O_CLOEXEC)};
    if (file.fd < 0) fail(path, "cannot open");
    struct stat status;
    if (fstat(file.fd, &status) != 0) fail(path, "cannot open");
    if (!S_ISREG(status.st_mode)) throw Error(path + ": not a regular file");
    const auto size = static_cast<uint64_t>(status.st_size);
    if (size > max_bytes) {
        throw Error(fmt::format("{}: {} bytes, more than the limit of {}", path, size, max_bytes));
    }
    std::vector<std::byte> data(size);
    size_t done = 0;
    while (done < size) {
        const ssize_t got = read(file.fd, data.data() + done, size - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail(path, "cannot read");
        if (got == 0) throw Error(path + ": became shorter while it was read");
        done += static_cast<size_t>(got);
    }
    return data;
}

void write_atomically(const std::string& path,
                      const std::function<void(const std::string& temporary)>& write) {
    namespace fs = std::filesystem;
    const fs::path target(path);
    const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
    // Libraries choose the format by the ending, so the temporary keeps it. The name is short
    // because the target's own may already be as long as the file system allows, and random
    // because another machine may be writing to the same folder.
    uint64_t random = 0;
    if (getrandom(&random, sizeof random, 0) != sizeof random) fail(path, "no random number");
    const fs::path temporary =
        folder / fmt::format("{}{:016x}{}", temporary_prefix, random, target.extension().string());
    try {
        write(temporary.string());
        sync(temporary.string());
        if (rename(temporary.c_str(), path.c_str()) != 0) fail(path, "cannot write");
    } catch (...) {
        std::error_code ignored;
        fs::remove(temporary, ignored);
        throw;
    }
    const Descriptor directory{open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
    if (directory.fd >= 0) fsync(directory.fd);
}

void write_file(const std::string& path, std::span<const std::byte> data) {
    write_atomically(path, [&](const std::string& temporary) {
        const Descriptor file{
            open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)};
        if (file.fd < 0) fail(path, "cannot write");
        for (size_t done = 0; done < data.size();) {
            const ssize_t wrote = write(file.fd, data.data() + done, data.size() - done);
            if (wrote < 0 && errno == EINTR) continue;
            if (wrote < 0) fail(path, "cannot write");
            done += static_cast<size_t>(wrote);
        }
    });
}

}  // namespace sightline
