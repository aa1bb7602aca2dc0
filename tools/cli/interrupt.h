#pragma once
#include <chrono>
#include <optional>
#include <stop_token>

namespace sightline {

/// Makes the first SIGINT or SIGTERM request a stop; the second kills as usual. If there is a limit
/// and the process has not ended that long after the first, it ends without writing what is not
/// written yet: files appear whole or not at all.
/// To be called before other threads start, so that all of them leave the signals to the thread
/// that waits here.
std::stop_source stop_on_signals(std::optional<std::chrono::milliseconds> limit = {});

}  // namespace sightline
