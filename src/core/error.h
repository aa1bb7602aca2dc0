#pragma once
#include "core/text.h"

#include <stdexcept>
#include <string>

namespace sightline {

/// An error caused by a file or the machine, not by the programmer. `what()` is one line: file,
/// place, reason, remedy; characters that would break the line are escaped. main catches it, prints
/// it and exits with code 1.
struct Error : std::runtime_error {
    explicit Error(const std::string& message) : std::runtime_error(printable(message)) {}
};

/// What a file holds exceeds a limit that the user can raise.
struct LimitError : Error {
    using Error::Error;
};

}  // namespace sightline
