#pragma once
#include <cstddef>
#include <functional>

namespace sightline {

/// Calls `work` so that the parallel loops within use at most `threads` threads; 0: no limit.
void run_with_threads(unsigned threads, const std::function<void()>& work);

/// Calls `body(i)` once for each i < n, several at a time; the order is not defined.
void parallel_for(size_t n, const std::function<void(size_t)>& body);

}  // namespace sightline
