#include "core/parallel.h"

#include <tbb/task_arena.h>

namespace sightline {

void run_with_threads(unsigned threads, const std::function<void()>& work) {
    if (threads == 0) return work();
    tbb::task_arena arena(static_cast<int>(threads));
    arena.execute(work);
}

}  // namespace sightline
