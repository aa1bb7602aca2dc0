#include "core/parallel.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <bit>
#include <cfenv>
#include <cstdint>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

namespace sightline {
namespace {

// The state of the calling thread while this lives, as Embree's builder leaves it on its threads.
class ForeignArithmetic {
  public:
    ForeignArithmetic() {
        std::fegetenv(&before_);
        std::fesetround(FE_UPWARD);
#ifdef __SSE__
        constexpr unsigned flush_to_zero = 1u << 15, denormals_are_zero = 1u << 6;
        _mm_setcsr(_mm_getcsr() | flush_to_zero | denormals_are_zero);
#endif
    }
    ~ForeignArithmetic() { std::fesetenv(&before_); }
    ForeignArithmetic(const ForeignArithmetic&) = delete;
    ForeignArithmetic& operator=(const ForeignArithmetic&) = delete;

  private:
    std::fenv_t before_;
};

// By bits: a comparison of numbers may flush them, too.
bool keeps_denormals() {
    volatile float least = 0x1p-149f, smallest_normal = 0x1p-126f, half = 0.5f;
    return std::bit_cast<uint32_t>(least + least) == 2 &&
           std::bit_cast<uint32_t>(smallest_normal * half) == 1u << 22;
}

bool rounds_to_nearest() {
    volatile float one = 1, quarter_ulp = 0x1p-25f;
    return one + quarter_ulp == 1 && std::fegetround() == FE_TONEAREST;
}

// Number of tasks, of a thousand, in which the arithmetic is not the default.
int count_foreign_tasks() {
    std::atomic<int> count{0};
    parallel_for(1000, [&](size_t) { count += !keeps_denormals() || !rounds_to_nearest(); });
    return count;
}

// The first loop of a process decides the state of TBB's default arena, and ctest runs each test in
// a process of its own.
TEST(Parallel, EveryTaskComputesAlikeWhateverTheStateOfTheCallingThread) {
    const ForeignArithmetic foreign;
    EXPECT_EQ(count_foreign_tasks(), 0);
    for (const unsigned threads : {1u, 2u, 3u}) {
        int count = -1;
        run_with_threads(threads, [&] { count = count_foreign_tasks(); });
        EXPECT_EQ(count, 0) << threads << " threads";
    }
}

TEST(Parallel, TheCallingThreadGetsItsStateBack) {
    const ForeignArithmetic foreign;
    parallel_for(10, [](size_t) {});
    EXPECT_EQ(std::fegetround(), FE_UPWARD);
#ifdef __SSE__
    EXPECT_FALSE(keeps_denormals());
#endif
}

TEST(Parallel, EachIndexIsVisitedOnce) {
    std::array<std::atomic<int>, 500> visits{};
    parallel_for(visits.size(), [&](size_t i) { ++visits[i]; });
    for (const auto& count : visits) EXPECT_EQ(count, 1);
}

}  // namespace
}  // namespace sightline
