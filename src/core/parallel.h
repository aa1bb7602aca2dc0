#pragma once
#include <cstddef>
#include <functional>

namespace sightline {

/// Calls `work`, in which parallel loops use at most `threads` threads; 0: no limit.
void run_with_threads(unsigned threads, const std::function<void()>& work);

/// Calls `body(i)` once for each i < n, in parallel and in no particular order.
void parallel_for(size_t n, const std::function<void(size_t)>& body);

/// Calls `body(begin, end)` for ranges that together are all i < n, in parallel if there are more
/// than `length`, which by default suits elements that take a few nanoseconds each.
void parallel_ranges(size_t n, const std::function<void(size_t, size_t)>& body,
                     size_t length = size_t{1} << 15);

}  // namespace sightline
