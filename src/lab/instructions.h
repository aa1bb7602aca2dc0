#pragma once
#include <cstdint>
#include <optional>

namespace sightline {

/// How many instructions the calling thread has executed in user space since it first asked:
/// a cost that other programs' load does not change. Nothing where the processor, as in most
/// virtual machines, or the system does not count them.
std::optional<uint64_t> thread_instructions();

}  // namespace sightline
