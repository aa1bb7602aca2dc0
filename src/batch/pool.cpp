#include "batch/pool.h"

#include "core/error.h"
#include "core/files.h"
#include "core/run_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>

namespace sightline {
namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t log_bytes = 4096;

struct Pipe {
    int read_end = -1, write_end = -1;

    Pipe() {
        int ends[2];
        if (pipe2(ends, O_CLOEXEC) != 0)
            throw Error(fmt::format("cannot start a worker: {}", std::strerror(errno)));
        read_end = ends[0];
        write_end = ends[1];
    }
    ~Pipe() {
        close_end(read_end);
        close_end(write_end);
    }
    Pipe(const Pipe&) = delete;

    static void close_end(int& end) {
        if (end >= 0) close(end);
        end = -1;
    }
};

enum class ReadResult { nothing, something, end_of_file };

// Appends what a non-blocking pipe holds to `text`.
ReadResult drain(int fd, std::string& text) {
    char buffer[4096];
    ReadResult result = ReadResult::nothing;
    for (;;) {
        const ssize_t got = read(fd, buffer, sizeof buffer);
        if (got > 0) {
            text.append(buffer, static_cast<size_t>(got));
            result = ReadResult::something;
        } else if (got == 0) {
            return ReadResult::end_of_file;
        } else if (errno != EINTR) {
            return errno == EAGAIN ? result : ReadResult::end_of_file;
        }
    }
}

// How many processes the kernel has killed for want of memory.
uint64_t count_kernel_kills() {
    std::ifstream events("/proc/vmstat");
    for (std::string name; events >> name;) {
        uint64_t count = 0;
        if (name == "oom_kill" && events >> count) return count;
    }
    return 0;
}

}  // namespace

struct WorkerPool::Worker {
    Pipe stdin_pipe, stdout_pipe, stderr_pipe;
    pid_t pid = -1;
    bool busy = false, timed_out = false, stderr_closed = false;
    size_t id = 0;
    std::string subject;  // of the last request that had one
    Clock::time_point start, deadline;
    std::string response, log;
    uint64_t kernel_kills = 0;  // before the request

    explicit Worker(const WorkerCommand& command);
    ~Worker() { kill_and_reap(); }
    void kill_and_reap();
    WorkerResponse describe_death(int status, uint64_t peak, uint64_t memory_mib) const;
    void read_log() {
        stderr_closed = drain(stderr_pipe.read_end, log) == ReadResult::end_of_file;
        if (log.size() > log_bytes) log.erase(0, log.size() - log_bytes);
    }
    double age() const { return std::chrono::duration<double>(Clock::now() - start).count(); }
};

WorkerPool::Worker::Worker(const WorkerCommand& command) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, stdin_pipe.read_end, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, stdout_pipe.write_end, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, stderr_pipe.write_end, STDERR_FILENO);
    std::vector<char*> argv = {const_cast<char*>(command.program.c_str())};
    for (const std::string& a : command.arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    const int error =
        posix_spawn(&pid, command.program.c_str(), &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error) {
        pid = -1;
        throw Error(
            fmt::format("{}: cannot start a worker: {}", command.program, std::strerror(error)));
    }
    Pipe::close_end(stdin_pipe.read_end);
    Pipe::close_end(stdout_pipe.write_end);
    Pipe::close_end(stderr_pipe.write_end);
    fcntl(stdout_pipe.read_end, F_SETFL, O_NONBLOCK);
    fcntl(stderr_pipe.read_end, F_SETFL, O_NONBLOCK);
}

void WorkerPool::Worker::kill_and_reap() {
    if (pid <= 0) return;
    kill(pid, SIGKILL);
    while (waitpid(pid, nullptr, 0) < 0 && errno == EINTR) continue;
    pid = -1;
}

WorkerResponse WorkerPool::Worker::describe_death(int status, uint64_t peak,
                                                  uint64_t memory_mib) const {
    WorkerResponse result{id, TaskVerdict::crashed, "", log, age(), peak};
    if (timed_out) {
        result.verdict = TaskVerdict::timeout;
        result.text = fmt::format("exceeded the time limit ({:.0f} s)", age());
    } else if (ended_for_memory({status, peak, count_kernel_kills() - kernel_kills, log},
                                memory_mib)) {
        result.verdict = TaskVerdict::out_of_memory;
        result.text = out_of_memory_message(memory_mib);
    } else if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) {
        result.verdict = TaskVerdict::killed;
        result.text = "killed from outside, possibly because the machine ran out of memory";
    } else {
        result.text = "the renderer crashed: " + describe_end(status);
    }
    return result;
}

// The limit may be met as a failed allocation that nothing catches, as a thread that cannot start,
// as a kill by the kernel, or as a crash of a library on memory that it did not get.
bool ended_for_memory(const WorkerEnd& end, uint64_t limit_mib) {
    const auto logged = [&](const char* text) { return end.log.find(text) != std::string::npos; };
    if (logged("bad_alloc") || logged("Cannot allocate memory")) return true;
    if (limit_mib && logged("Resource temporarily unavailable")) return true;
    if (!WIFSIGNALED(end.status)) return false;
    if (WTERMSIG(end.status) == SIGKILL && end.kernel_kills > 0) return true;
    return limit_mib && end.peak / 9 >= (limit_mib << 20) / 10;
}

std::string out_of_memory_message(uint64_t limit_mib) {
    if (limit_mib == 0) return "out of memory: the machine has no more";
    return fmt::format("out of memory: needs more than the limit of {} MiB (--memory)", limit_mib);
}

WorkerPool::WorkerPool(WorkerCommand command) : command_(std::move(command)) {
    // Writing to a worker that has died must not end this process; `collect` reports the death.
    std::signal(SIGPIPE, SIG_IGN);
}

WorkerPool::~WorkerPool() = default;

WorkerPool::Worker& WorkerPool::idle_worker(const std::string& subject) {
    Worker* idle = nullptr;
    for (const auto& worker : workers_) {
        if (worker->busy) continue;
        if (!subject.empty() && worker->subject == subject) return *worker;
        // Rather one whose memory holds nothing than one that may be asked for again.
        if (!idle || worker->subject.empty()) idle = worker.get();
    }
    if (idle) return *idle;
    return *workers_.emplace_back(std::make_unique<Worker>(command_));
}

WorkerPool::Holder WorkerPool::holder_of(const std::string& subject) const {
    Holder holder = Holder::nobody;
    for (const auto& worker : workers_) {
        if (worker->subject != subject) continue;
        if (!worker->busy) return Holder::idle;
        holder = Holder::busy;
    }
    return holder;
}

void WorkerPool::submit(size_t id, const std::string& request, double timeout,
                        const std::string& subject) {
    Worker& worker = idle_worker(subject);
    if (!subject.empty()) worker.subject = subject;
    worker.busy = true;
    worker.id = id;
    worker.start = Clock::now();
    worker.deadline = timeout > 0 ? worker.start + std::chrono::duration_cast<Clock::duration>(
                                                       std::chrono::duration<double>(timeout))
                                  : Clock::time_point::max();
    worker.response.clear();
    worker.log.clear();
    worker.kernel_kills = count_kernel_kills();
    // The worker reads a whole line before it starts, so this cannot block for long.
    const std::string line = request + "\n";
    write_all(worker.stdin_pipe.write_end, std::as_bytes(std::span(line)));
}

size_t WorkerPool::running() const {
    return static_cast<size_t>(
        std::count_if(workers_.begin(), workers_.end(), [](const auto& w) { return w->busy; }));
}

std::optional<WorkerResponse> WorkerPool::collect(Worker& worker) {
    worker.read_log();
    const bool ended =
        drain(worker.stdout_pipe.read_end, worker.response) == ReadResult::end_of_file;
    if (worker.busy && worker.response.ends_with('\n')) {
        worker.busy = false;
        worker.response.pop_back();
        return WorkerResponse{worker.id,  TaskVerdict::ok, worker.response,
                              worker.log, worker.age(),    0};
    }
    if (!ended) {
        if (worker.busy && !worker.timed_out && Clock::now() > worker.deadline) {
            worker.timed_out = true;
            kill(worker.pid, SIGKILL);
        }
        return std::nullopt;
    }
    int status = 0;
    rusage usage{};
    while (wait4(worker.pid, &status, 0, &usage) < 0 && errno == EINTR) continue;
    worker.pid = -1;
    if (!worker.busy) return std::nullopt;
    worker.read_log();
    return worker.describe_death(status, static_cast<uint64_t>(usage.ru_maxrss) * 1024,
                                 command_.memory_mib);
}

std::vector<WorkerResponse> WorkerPool::wait(double seconds) {
    auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                    std::chrono::duration<double>(seconds));
    std::vector<pollfd> fds;
    for (const auto& worker : workers_) {
        fds.push_back({worker->stdout_pipe.read_end, POLLIN, 0});
        // poll() would return at once for a closed pipe, again and again until the process ends.
        fds.push_back({worker->stderr_closed ? -1 : worker->stderr_pipe.read_end, POLLIN, 0});
        if (worker->busy && !worker->timed_out) until = std::min(until, worker->deadline);
    }
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now());
    poll(fds.data(), fds.size(), static_cast<int>(std::max<int64_t>(left.count() + 1, 0)));
    std::vector<WorkerResponse> responses;
    for (const auto& worker : workers_)
        if (auto response = collect(*worker)) responses.push_back(std::move(*response));
    std::erase_if(workers_, [](const auto& worker) { return worker->pid < 0; });
    return responses;
}

std::vector<int> WorkerPool::processes() const {
    std::vector<int> ids;
    for (const auto& worker : workers_) ids.push_back(worker->pid);
    return ids;
}

}  // namespace sightline
