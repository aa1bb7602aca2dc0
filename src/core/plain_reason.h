#pragma once
#include <exception>
#include <string>

namespace sightline {

/// What an exception says, without a library's marks around it: for a fault of a file or the system
/// the path and the reason, for others the text from the reason on.
std::string plain_reason(const std::exception& exception);

}  // namespace sightline
