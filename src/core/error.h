#pragma once
#include <stdexcept>
#include <string>

namespace sightline {

/// A file or the machine is at fault. `what()` is one line: file, place, reason, what to do.
/// Caught once, in main, which prints it and exits with 1.
struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

}  // namespace sightline
