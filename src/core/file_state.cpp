#include "core/file_state.h"

#include <sys/stat.h>

#include <algorithm>
#include <ctime>

namespace sightline {
namespace {

int64_t nanoseconds(const timespec& time) { return time.tv_sec * 1'000'000'000 + time.tv_nsec; }

}  // namespace

std::optional<FileState> state_of_file(const std::string& path) {
    struct stat status {};
    if (stat(path.c_str(), &status) != 0) return {};
    return FileState{status.st_dev, status.st_ino, static_cast<uint64_t>(status.st_size),
                     nanoseconds(status.st_mtim), nanoseconds(status.st_ctim)};
}

bool is_settled(const FileState& state, int64_t time) {
    return time - std::max(state.modified, state.changed) > 2'000'000'000;
}

int64_t nanoseconds_now() {
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    return nanoseconds(now);
}

}  // namespace sightline
