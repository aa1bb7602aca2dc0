#pragma once
#include <cstdint>
#include <optional>

namespace sightline {

/// Instructions that the calling thread has executed in user space since its first call: a cost
/// that does not depend on the machine's load. None if the processor (as in most virtual machines)
/// or the system does not count them.
std::optional<uint64_t> thread_instructions();

}  // namespace sightline
