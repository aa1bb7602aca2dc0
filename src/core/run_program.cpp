#include "core/run_program.h"

#include "core/descriptor.h"
#include "core/error.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <utility>

namespace sightline {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& program, int error) {
    throw Error(fmt::format("{}: cannot be started: {}", program, std::strerror(error)));
}

// A file in memory: a pipe that nobody reads while the input is written could fill.
int memory_file(const std::string& program) {
    const int fd = memfd_create("output", MFD_CLOEXEC);
    if (fd < 0) fail(program, errno);
    return fd;
}

std::string text_of(int fd) {
    struct stat status {};
    if (fstat(fd, &status) != 0) return "";
    std::string text(static_cast<size_t>(status.st_size), '\0');
    const ssize_t got = pread(fd, text.data(), text.size(), 0);
    text.resize(got > 0 ? static_cast<size_t>(got) : 0);
    return text;
}

// What the program starts with: its streams, no blocked or ignored signals, its own group.
struct SpawnSetup {
    posix_spawn_file_actions_t streams;
    posix_spawnattr_t attributes;

    SpawnSetup(int in, int out, int err) {
        posix_spawn_file_actions_init(&streams);
        posix_spawn_file_actions_adddup2(&streams, in, STDIN_FILENO);
        posix_spawn_file_actions_adddup2(&streams, out, STDOUT_FILENO);
        posix_spawn_file_actions_adddup2(&streams, err, STDERR_FILENO);
        posix_spawnattr_init(&attributes);
        sigset_t signals;
        sigemptyset(&signals);
        posix_spawnattr_setsigmask(&attributes, &signals);
        sigaddset(&signals, SIGPIPE);
        posix_spawnattr_setsigdefault(&attributes, &signals);
        posix_spawnattr_setpgroup(&attributes, 0);
        posix_spawnattr_setflags(
            &attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    }
    ~SpawnSetup() {
        posix_spawn_file_actions_destroy(&streams);
        posix_spawnattr_destroy(&attributes);
    }
    SpawnSetup(const SpawnSetup&) = delete;
};

pid_t start(std::vector<std::string>& command, int in, int out, int err) {
    std::vector<char*> words;
    for (std::string& word : command) words.push_back(word.data());
    words.push_back(nullptr);
    const SpawnSetup setup(in, out, err);
    pid_t pid = -1;
    const int error =
        posix_spawn(&pid, words[0], &setup.streams, &setup.attributes, words.data(), environ);
    if (error) fail(command[0], error);
    return pid;
}

// Waits for the process in any case, so that none is left behind.
class Child {
  public:
    explicit Child(pid_t pid) : pid_(pid) {}
    ~Child() {
        if (pid_ <= 0) return;
        kill(pid_, SIGKILL);
        wait();
    }
    Child(const Child&) = delete;

    pid_t pid() const { return pid_; }
    int wait() {
        int status = 0;
        while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) continue;
        pid_ = -1;
        return status;
    }

  private:
    pid_t pid_;
};

// The absolute path of the file if it can be run, otherwise "".
std::string executable(const fs::path& file) {
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored) || access(file.c_str(), X_OK) != 0) return "";
    return fs::absolute(file, ignored).string();
}

}  // namespace

std::string describe_end(int wait_status) {
    if (!WIFSIGNALED(wait_status)) return fmt::format("exit status {}", WEXITSTATUS(wait_status));
    const int signal = WTERMSIG(wait_status);
    return fmt::format("signal {} ({})", signal, strsignal(signal));
}

std::string find_program(const std::string& name) {
    if (name.find('/') != std::string::npos) return executable(name);
    const char* path = std::getenv("PATH");
    std::istringstream folders(path ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');)
        if (std::string file = executable(fs::path(folder.empty() ? "." : folder) / name);
            !file.empty())
            return file;
    return "";
}

ProgramEnd run_program(std::vector<std::string> command, const ProgramInput& input,
                       std::stop_token stop) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) fail(command[0], errno);
    Descriptor read_end(ends[0]), write_end(ends[1]);
    const Descriptor output(memory_file(command[0])), errors(memory_file(command[0]));
    Child child(start(command, read_end.get(), output.get(), errors.get()));
    read_end.reset();
    int status = 0;
    {
        const std::stop_callback killer(std::move(stop),
                                        [pid = child.pid()] { kill(pid, SIGKILL); });
        while (input) {
            const FileBytes data = input();
            if (data.empty() || !write_all(write_end.get(), data)) break;
        }
        write_end.reset();
        // Not reaped yet, so that the callback kills no other process of this number.
        siginfo_t ended;
        while (waitid(P_PID, static_cast<id_t>(child.pid()), &ended, WEXITED | WNOWAIT) < 0 &&
               errno == EINTR)
            continue;
    }
    status = child.wait();
    return {WIFEXITED(status) ? std::optional(WEXITSTATUS(status)) : std::nullopt,
            text_of(output.get()), text_of(errors.get()), describe_end(status)};
}

std::string last_line(const std::string& text) {
    std::istringstream lines(text);
    std::string last;
    for (std::string line; std::getline(lines, line);)
        if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
    return last;
}

}  // namespace sightline
