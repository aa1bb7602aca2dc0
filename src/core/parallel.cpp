#include "core/parallel.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <thread>
#include <vector>

namespace sightline {

void run_with_threads(unsigned threads, const std::function<void()>& work) {
    if (threads == 0) return work();
    tbb::task_arena arena(static_cast<int>(threads));
    arena.execute(work);
}

#ifdef __SANITIZE_THREAD__
// The thread sanitizer does not see the synchronisation inside Debian's TBB and would report false
// races, so this loop runs on threads of the standard library.
void parallel_for(size_t n, const std::function<void(size_t)>& body) {
    std::atomic<size_t> next{0};
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i)
        threads.emplace_back([&] {
            for (size_t k; (k = next++) < n;) body(k);
        });
}
#else
void parallel_for(size_t n, const std::function<void(size_t)>& body) {
    tbb::parallel_for(size_t{0}, n, body, tbb::simple_partitioner());
}
#endif

}  // namespace sightline
