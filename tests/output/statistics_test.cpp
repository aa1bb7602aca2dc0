#include "output/statistics.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>

namespace sightline {
namespace {

// Every member, so that one that is added later is not forgotten.
using Members = std::array<double, sizeof(StageTimes) / sizeof(double)>;

TEST(StageTimes, AddsEveryStage) {
    Members ones;
    ones.fill(1);
    StageTimes sum;
    for (int i = 0; i < 3; ++i) sum.add(std::bit_cast<StageTimes>(ones));
    for (const double member : std::bit_cast<Members>(sum)) EXPECT_EQ(member, 3);
}

}  // namespace
}  // namespace sightline
