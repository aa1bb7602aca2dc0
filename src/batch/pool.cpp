#include "batch/pool.h"

#include "core/error.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>

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

enum class Reading { nothing, something, ended };

// Takes what a non-blocking pipe holds.
Reading drain(int fd, std::string& text) {
    char piece[4096];
    Reading result = Reading::nothing;
    for (;;) {
        const ssize_t got = read(fd, piece, sizeof piece);
        if (got > 0) {
            text.append(piece, static_cast<size_t>(got));
            result = Reading::something;
        } else if (got == 0) {
            return Reading::ended;
        } else if (errno != EINTR) {
            return errno == EAGAIN ? result : Reading::ended;
        }
    }
}

std::string describe_status(int status) {
    if (WIFSIGNALED(status))
        return fmt::format("signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
    return fmt::format("it ended with status {}", WEXITSTATUS(status));
}

}  // namespace

struct WorkerPool::Worker {
    Pipe requests, answers, messages;
    pid_t pid = -1;
    bool busy = false, killed_late = false, mute = false;
    size_t id = 0;
    Clock::time_point start, deadline;
    std::string answer, log;

    explicit Worker(const WorkerCommand& command);
    ~Worker() { end(); }
    void end();
    void read_log() {
        mute = drain(messages.read_end, log) == Reading::ended;
        if (log.size() > log_bytes) log.erase(0, log.size() - log_bytes);
    }
    double age() const { return std::chrono::duration<double>(Clock::now() - start).count(); }
};

WorkerPool::Worker::Worker(const WorkerCommand& command) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, requests.read_end, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, answers.write_end, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, messages.write_end, STDERR_FILENO);
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
    Pipe::close_end(requests.read_end);
    Pipe::close_end(answers.write_end);
    Pipe::close_end(messages.write_end);
    fcntl(answers.read_end, F_SETFL, O_NONBLOCK);
    fcntl(messages.read_end, F_SETFL, O_NONBLOCK);
}

void WorkerPool::Worker::end() {
    if (pid <= 0) return;
    kill(pid, SIGKILL);
    while (waitpid(pid, nullptr, 0) < 0 && errno == EINTR) continue;
    pid = -1;
}

WorkerPool::WorkerPool(WorkerCommand command) : command_(std::move(command)) {
    // A worker may be gone when it is written to; that is found out by its answer.
    std::signal(SIGPIPE, SIG_IGN);
}

WorkerPool::~WorkerPool() = default;

WorkerPool::Worker& WorkerPool::idle_worker() {
    for (const auto& worker : workers_)
        if (!worker->busy) return *worker;
    return *workers_.emplace_back(std::make_unique<Worker>(command_));
}

void WorkerPool::submit(size_t id, const std::string& request, double timeout) {
    Worker& worker = idle_worker();
    worker.busy = true;
    worker.id = id;
    worker.start = Clock::now();
    worker.deadline = timeout > 0 ? worker.start + std::chrono::duration_cast<Clock::duration>(
                                                       std::chrono::duration<double>(timeout))
                                  : Clock::time_point::max();
    worker.answer.clear();
    worker.log.clear();
    // The worker reads a whole line before it works, so this cannot block for long.
    const std::string line = request + "\n";
    for (size_t done = 0; done < line.size();) {
        const ssize_t wrote =
            write(worker.requests.write_end, line.data() + done, line.size() - done);
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote < 0) break;
        done += static_cast<size_t>(wrote);
    }
}

size_t WorkerPool::running() const {
    return static_cast<size_t>(
        std::count_if(workers_.begin(), workers_.end(), [](const auto& w) { return w->busy; }));
}

std::optional<WorkerResponse> WorkerPool::check(Worker& worker) {
    worker.read_log();
    const bool ended = drain(worker.answers.read_end, worker.answer) == Reading::ended;
    if (worker.busy && worker.answer.ends_with('\n')) {
        worker.busy = false;
        worker.answer.pop_back();
        return WorkerResponse{worker.id, TaskVerdict::ok, worker.answer, worker.log, worker.age()};
    }
    if (!ended) {
        if (worker.busy && !worker.killed_late && Clock::now() > worker.deadline) {
            worker.killed_late = true;
            kill(worker.pid, SIGKILL);
        }
        return std::nullopt;
    }
    int status = 0;
    while (waitpid(worker.pid, &status, 0) < 0 && errno == EINTR) continue;
    worker.pid = -1;
    if (!worker.busy) return std::nullopt;
    worker.read_log();
    WorkerResponse answer{worker.id, TaskVerdict::crashed, "", worker.log, worker.age()};
    if (worker.killed_late) {
        answer.verdict = TaskVerdict::timeout;
        answer.text = fmt::format("not done after {:.0f} s", worker.age());
    } else if (worker.log.find("bad_alloc") != std::string::npos) {
        answer.verdict = TaskVerdict::out_of_memory;
        answer.text = "out of memory";
    } else if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) {
        answer.verdict = TaskVerdict::killed;
        answer.text = "killed from outside, perhaps because the machine was out of memory";
    } else {
        answer.text = "the renderer crashed: " + describe_status(status);
    }
    return answer;
}

std::vector<WorkerResponse> WorkerPool::wait(double seconds) {
    auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                    std::chrono::duration<double>(seconds));
    std::vector<pollfd> fds;
    for (const auto& worker : workers_) {
        fds.push_back({worker->answers.read_end, POLLIN, 0});
        // An ended pipe would wake us again and again until the process is gone.
        fds.push_back({worker->mute ? -1 : worker->messages.read_end, POLLIN, 0});
        if (worker->busy && !worker->killed_late) until = std::min(until, worker->deadline);
    }
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now());
    poll(fds.data(), fds.size(), static_cast<int>(std::max<int64_t>(left.count() + 1, 0)));
    std::vector<WorkerResponse> answers;
    for (const auto& worker : workers_)
        if (auto answer = check(*worker)) answers.push_back(std::move(*answer));
    std::erase_if(workers_, [](const auto& worker) { return worker->pid < 0; });
    return answers;
}

std::vector<int> WorkerPool::processes() const {
    std::vector<int> ids;
    for (const auto& worker : workers_) ids.push_back(worker->pid);
    return ids;
}

}  // namespace sightline
