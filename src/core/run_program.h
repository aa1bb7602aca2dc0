#pragma once
// Other programs, run to their end.
#include "core/files.h"

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace sightline {

/// How a program ended.
struct ProgramEnd {
    std::optional<int> status;  ///< the exit status; none if a signal ended it
    std::string output;         ///< what it wrote to stdout
    std::string errors;         ///< what it wrote to stderr
    std::string how;            ///< as describe_end() says it

    bool succeeded() const { return status == 0; }
};

/// The end of a process in words, of the status that waitpid() gives: "exit status 1",
/// "signal 9 (Killed)".
std::string describe_end(int wait_status);

/// The absolute path of an executable file: of this path if the name has a slash, otherwise of the
/// first of this name in PATH. Empty if there is none.
std::string find_program(const std::string& name);

/// Gives the program its next input, or nothing at the end.
using ProgramInput = std::function<FileBytes()>;

/// Runs a command, of which the first word is the program's path, without a shell and in a process
/// group of its own, so that a terminal's Ctrl-C does not reach it. Its stdin is what `input` gives
/// until that is empty; a program that stops reading gets no more, if SIGPIPE is ignored. A stop
/// request kills it. What it writes is held in memory. Throws Error if it cannot be started, and
/// what `input` throws.
ProgramEnd run_program(std::vector<std::string> command, const ProgramInput& input = {},
                       std::stop_token stop = {});

/// The last line of a text that is not blank.
std::string last_line(const std::string& text);

}  // namespace sightline
