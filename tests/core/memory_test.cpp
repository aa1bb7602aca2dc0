#include "core/memory.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(Memory, APeakBeginsAnewWhenItIsReset) {
    if (SIGHTLINE_SANITIZED) GTEST_SKIP() << "sanitizers keep freed memory";
    constexpr size_t size = size_t{128} << 20;
    const uint64_t before = peak_memory();
    { const std::vector<char> large(size, 1); }
    EXPECT_GE(peak_memory(), before + size / 2);
    reset_peak_memory();
    EXPECT_LT(peak_memory(), before + size / 2);
}

}  // namespace
}  // namespace sightline
