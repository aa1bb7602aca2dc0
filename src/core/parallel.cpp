#include "core/parallel.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace sightline {

void run_with_threads(unsigned threads, const std::function<void()>& work) {
    if (threads == 0) return work();
    tbb::task_arena arena(static_cast<int>(threads));
    arena.execute(work);
}

void parallel_for(size_t n, const std::function<void(size_t)>& body) {
    tbb::parallel_for(size_t{0}, n, body, tbb::simple_partitioner());
}

}  // namespace sightline
