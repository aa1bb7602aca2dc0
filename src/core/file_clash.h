#pragma once
#include "core/error.h"

#include <span>
#include <string>

namespace sightline {

/// A run would write to a file that it reads. main exits with 2: the command line is at fault.
struct OutputIsInput : Error {
    using Error::Error;
};

/// Throws OutputIsInput, naming both, if one of the outputs exists and is the same file as one of
/// the inputs: by device and inode, so that links and other spellings of a path are recognised.
/// Empty names and files that do not exist are ignored.
void check_outputs_are_not_inputs(std::span<const std::string> outputs,
                                  std::span<const std::string> inputs);

}  // namespace sightline
