#pragma once
#include "core/text.h"

#include <stdexcept>
#include <string>

namespace sightline {

/// A file or the machine is at fault. `what()` is one line: file, place, reason, what to do; what
/// would break the line is made printable. Caught once, in main, which prints it and exits with 1.
struct Error : std::runtime_error {
    explicit Error(const std::string& message) : std::runtime_error(printable(message)) {}
};

}  // namespace sightline
