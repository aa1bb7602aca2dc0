#include "lab/instructions.h"

#include <linux/perf_event.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace sightline {
namespace {

/// Counts the instructions of the thread that constructs it.
class Counter {
  public:
    Counter() {
        perf_event_attr attributes{};
        attributes.size = sizeof attributes;
        attributes.type = PERF_TYPE_HARDWARE;
        attributes.config = PERF_COUNT_HW_INSTRUCTIONS;
        attributes.exclude_kernel = attributes.exclude_hv = 1;
        fd_ = static_cast<int>(
            syscall(SYS_perf_event_open, &attributes, 0, -1, -1, PERF_FLAG_FD_CLOEXEC));
    }
    ~Counter() {
        if (fd_ >= 0) close(fd_);
    }
    Counter(const Counter&) = delete;

    std::optional<uint64_t> count() const {
        uint64_t value = 0;
        if (fd_ < 0 || read(fd_, &value, sizeof value) != sizeof value) return std::nullopt;
        return value;
    }

  private:
    int fd_ = -1;
};

}  // namespace

std::optional<uint64_t> thread_instructions() {
    thread_local const Counter counter;
    return counter.count();
}

}  // namespace sightline
