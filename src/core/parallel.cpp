#include "core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cfenv>
#include <optional>
#include <thread>
#include <vector>

namespace sightline {
namespace {

// The thread's arithmetic, while this lives: rounding to nearest, denormal numbers are kept. The
// state of before returns at the end.
class DefaultArithmetic {
  public:
    DefaultArithmetic() {
        std::fegetenv(&before_);
        std::fesetenv(FE_DFL_ENV);
    }
    ~DefaultArithmetic() { std::fesetenv(&before_); }
    DefaultArithmetic(const DefaultArithmetic&) = delete;
    DefaultArithmetic& operator=(const DefaultArithmetic&) = delete;

  private:
    std::fenv_t before_;
};

}  // namespace

void run_with_threads(unsigned threads, const std::function<void()>& work) {
    if (threads == 0) return work();
    // Otherwise TBB starts no more threads than there are cores, and says so on stderr.
    std::optional<tbb::global_control> more;
    if (threads > std::thread::hardware_concurrency())
        more.emplace(tbb::global_control::max_allowed_parallelism, threads);
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
            const DefaultArithmetic arithmetic;
            for (size_t k; (k = next++) < n;) body(k);
        });
}
#else
// Without a context of its own, a loop runs in the arithmetic of the thread that first used TBB's
// default arena. That may be Embree, which flushes denormal numbers to zero while it builds.
void parallel_for(size_t n, const std::function<void(size_t)>& body) {
    const DefaultArithmetic arithmetic;
    using Context = tbb::task_group_context;
    Context context(Context::bound, Context::default_traits | Context::fp_settings);
    tbb::parallel_for(size_t{0}, n, body, tbb::simple_partitioner(), context);
}
#endif

void parallel_ranges(size_t n, const std::function<void(size_t, size_t)>& body, size_t length) {
    if (n == 0) return;
    if (n <= length) return body(0, n);
    parallel_for((n + length - 1) / length,
                 [&](size_t k) { body(k * length, std::min(n, (k + 1) * length)); });
}

}  // namespace sightline
