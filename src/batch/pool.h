#pragma once
// Worker processes: a task that crashes, hangs or eats the memory takes only its worker along.
#include "batch/task.h"

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sightline {

/// How to start a worker.
struct WorkerCommand {
    std::string program;                 ///< path
    std::vector<std::string> arguments;  ///< after the program's name
};

/// What came of one request.
struct WorkerResponse {
    size_t id = 0;
    TaskVerdict verdict = TaskVerdict::ok;  ///< ok: the worker answered
    std::string text;                       ///< its answer; otherwise why there is none
    std::string log;                        ///< the last lines that it wrote to stderr meanwhile
    double seconds = 0;
};

/// Processes that take one line and give one line, used again while they behave. Single-threaded:
/// everything happens in the caller's thread. No request or answer may hold a line break.
class WorkerPool {
  public:
    explicit WorkerPool(WorkerCommand command);
    /// Kills what still runs.
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;

    /// Hands a request to an idle worker, started where there is none. A worker that has not
    /// answered after `timeout` seconds (0: never) is killed. Throws Error where no process can
    /// be started.
    void submit(size_t id, const std::string& request, double timeout);

    /// Requests that were handed out and not yet answered.
    size_t running() const;

    /// Waits until something ended, `seconds` passed or a signal came; gives what ended.
    std::vector<WorkerResponse> wait(double seconds);

    /// Process ids of the workers, the idle ones too.
    std::vector<int> processes() const;

  private:
    struct Worker;
    Worker& idle_worker();
    std::optional<WorkerResponse> check(Worker& worker);

    WorkerCommand command_;
    std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace sightline
