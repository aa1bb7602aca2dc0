#pragma once
// Worker processes: a task that crashes, hangs or exhausts memory affects only its worker.
#include "batch/task.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// How to start a worker.
struct WorkerCommand {
    std::string program;                 ///< path
    std::vector<std::string> arguments;  ///< after the program's name
    uint64_t memory_mib = 0;             ///< what a worker may allocate; 0: unlimited
};

/// The result of one request.
struct WorkerResponse {
    size_t id = 0;
    TaskVerdict verdict = TaskVerdict::ok;  ///< ok: the worker responded
    std::string text;                       ///< the response; otherwise why there is none
    std::string log;                        ///< the end of what it wrote to stderr meanwhile
    double seconds = 0;
    uint64_t memory = 0;  ///< peak of a worker that has died, bytes
};

/// Why a task ended that met the memory limit, in MiB (0: none but the machine's).
std::string out_of_memory_message(uint64_t limit_mib);

/// How a worker ended that gave no response.
struct WorkerEnd {
    int status = 0;             ///< of waitpid
    uint64_t peak = 0;          ///< of its memory, bytes
    uint64_t kernel_kills = 0;  ///< processes that the kernel killed meanwhile for want of memory
    std::string_view log;       ///< the end of what it wrote to stderr
};

/// Whether a worker ended for want of memory: it says so, the kernel killed it, or a signal ended
/// it at nine tenths of its limit or more, as when a library uses memory that it did not get.
/// `limit_mib` is 0 if there is none but the machine's.
bool ended_for_memory(const WorkerEnd& end, uint64_t limit_mib);

/// Processes that read a request and write a response, one line each, and are reused until they
/// fail. Everything happens in the caller's thread. Requests and responses contain no line break.
class WorkerPool {
  public:
    explicit WorkerPool(WorkerCommand command);
    /// Kills the workers.
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;

    /// Sends a request to an idle worker, or to a new one if there is none. `subject` names what it
    /// is about, or is empty; a worker whose last request was about the same, and that may still
    /// have it in memory, is preferred. A worker that does not respond within `timeout` seconds (0:
    /// no limit) is killed. Throws Error if no process can be started.
    void submit(size_t id, const std::string& request, double timeout,
                const std::string& subject = {});

    /// Whether the last request about the subject is still running; whether the worker that has
    /// answered it is idle.
    enum class Holder { nobody, busy, idle };
    Holder holder_of(const std::string& subject) const;

    /// The number of requests without a response yet.
    size_t running() const;

    /// Waits until a worker writes or ends, `seconds` pass or a signal arrives. Returns the
    /// complete responses.
    std::vector<WorkerResponse> wait(double seconds);

    /// Process ids of all workers, including idle ones.
    std::vector<int> processes() const;

  private:
    struct Worker;
    Worker& idle_worker(const std::string& subject);
    std::optional<WorkerResponse> collect(Worker& worker);

    WorkerCommand command_;
    std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace sightline
