#include "core/beneath.h"

#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>
#include <vector>

namespace sightline {
namespace {

constexpr int open_flags = O_RDONLY | O_CLOEXEC | O_NONBLOCK;

/// The folders from the outermost, which is never left, to the current one.
class FolderStack {
  public:
    explicit FolderStack(int outermost) { folders_.push_back(outermost); }
    ~FolderStack() {
        const int error = errno;
        for (const int folder : folders_) close(folder);
        errno = error;
    }
    FolderStack(const FolderStack&) = delete;

    int current() const { return folders_.back(); }
    void enter(int folder) { folders_.push_back(folder); }
    bool leave() {
        if (folders_.size() == 1) return false;
        close(folders_.back());
        folders_.pop_back();
        return true;
    }

  private:
    std::vector<int> folders_;
};

/// Puts the components of a path in front of those that are left, which are in reverse.
void push_components(std::string_view path, std::vector<std::string>& left) {
    std::vector<std::string> names;
    while (!path.empty()) {
        const size_t end = std::min(path.find('/'), path.size());
        if (end > 0) names.emplace_back(path.substr(0, end));
        path.remove_prefix(std::min(end + 1, path.size()));
    }
    left.insert(left.end(), names.rbegin(), names.rend());
}

int fail(int error) {
    errno = error;
    return -1;
}

int open_by_components(int outermost, const std::string& path) {
    constexpr int max_links = 40;  // as in Linux
    FolderStack folders(outermost);
    if (path.starts_with('/')) return fail(EXDEV);
    std::vector<std::string> left;
    push_components(path, left);
    for (int links = 0; !left.empty();) {
        const std::string name = std::move(left.back());
        left.pop_back();
        if (name == ".") continue;
        if (name == "..") {
            if (!folders.leave()) return fail(EXDEV);
            continue;
        }
        const int fd = openat(folders.current(), name.c_str(), open_flags | O_NOFOLLOW);
        if (fd >= 0 && left.empty()) return fd;
        if (fd >= 0) {
            folders.enter(fd);
            continue;
        }
        if (errno != ELOOP || ++links > max_links) return -1;
        std::array<char, 4096> target{};
        const ssize_t size =
            readlinkat(folders.current(), name.c_str(), target.data(), target.size());
        if (size < 0) return -1;
        const std::string_view text(target.data(), static_cast<size_t>(size));
        if (text.starts_with('/')) return fail(EXDEV);
        push_components(text, left);
    }
    return fail(EISDIR);
}

/// False where the kernel lacks openat2, a sandbox forbids it, or renames disturb it.
bool open_by_kernel(int folder, const std::string& path, int& fd) {
    open_how how{};
    how.flags = open_flags;
    how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS;
    fd = static_cast<int>(syscall(SYS_openat2, folder, path.c_str(), &how, sizeof how));
    return fd >= 0 || (errno != ENOSYS && errno != EPERM && errno != EAGAIN);
}

}  // namespace

int open_beneath(const std::string& folder, const std::string& path, Resolver resolver) {
    const int outermost = open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (outermost < 0) return -1;
    int fd = -1;
    if (resolver == Resolver::by_components || !open_by_kernel(outermost, path, fd))
        return open_by_components(outermost, path);
    const int error = errno;
    close(outermost);
    errno = error;
    return fd;
}

}  // namespace sightline
