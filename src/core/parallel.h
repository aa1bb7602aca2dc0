#pragma once
#include <functional>

namespace sightline {

/// Calls `work` so that the parallel loops within use at most `threads` threads; 0: no limit.
void run_with_threads(unsigned threads, const std::function<void()>& work);

}  // namespace sightline
