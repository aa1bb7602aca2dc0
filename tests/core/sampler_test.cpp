#include "core/sampler.h"

#include <gtest/gtest.h>

#include <set>

namespace sightline {
namespace {

// Every elementary interval of area 1/16 holds exactly one of the first 16 points: the defining
// property of a (0,2)-sequence, which scrambling and shuffling of aligned blocks must keep.
TEST(Sampler, SixteenPointsStratifyEveryElementaryInterval) {
    for (uint32_t seed = 0; seed < 200; ++seed) {
        for (int bits_x = 0; bits_x <= 4; ++bits_x) {
            const int nx = 1 << bits_x, ny = 16 / nx;
            std::set<int> cells;
            for (uint32_t i = 0; i < 16; ++i) {
                const Vec2 u = sample_2d(i, seed);
                const int x = static_cast<int>(u.x * static_cast<float>(nx));
                const int y = static_cast<int>(u.y * static_cast<float>(ny));
                cells.insert(y * nx + x);
            }
            EXPECT_EQ(cells.size(), 16u) << "seed " << seed << ", " << nx << " columns";
        }
    }
}

TEST(Sampler, PointsLieInTheHalfOpenUnitSquare) {
    for (uint32_t i = 0; i < 100000; ++i) {
        const Vec2 u = sample_2d(i, i * 2654435761u);
        ASSERT_TRUE(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1);
    }
}

TEST(Sampler, ManyPointsAtOnceAreTheSameAsOneByOne) {
    std::vector<uint32_t> indices, seeds;
    for (uint32_t i = 0; i < 1001; ++i) {
        indices.push_back(i * 7);
        seeds.push_back(i * 2654435761u);
    }
    std::vector<float> x(indices.size()), y(indices.size());
    sample_2d(indices, seeds, 5, x, y);
    for (size_t i = 0; i < indices.size(); ++i)
        ASSERT_EQ(Vec2(x[i], y[i]), sample_2d(indices[i], hash_combine(seeds[i], 5))) << i;
}

TEST(Sampler, DifferentSeedsAreUncorrelated) {
    double sum = 0;
    constexpr int n = 20000;
    for (uint32_t seed = 0; seed < n; ++seed)
        sum += (static_cast<double>(sample_2d(0, seed).x) - 0.5) *
               (static_cast<double>(sample_2d(0, seed + 1).y) - 0.5);
    // The product of two independent uniforms about their means has deviation 1/12.
    EXPECT_LT(std::fabs(sum / n), 4.0 / 12 / std::sqrt(n));
}

TEST(Sampler, TheDiscMapFillsTheUnitDiscEvenly) {
    int inside_half = 0;
    constexpr int n = 4096;
    for (uint32_t i = 0; i < n; ++i) {
        const Vec2 p = sample_disc(sample_2d(i, 7));
        const float r2 = p.x * p.x + p.y * p.y;
        ASSERT_LE(r2, 1.0f + 1e-6f);
        inside_half += r2 < 0.5f;
    }
    EXPECT_NEAR(inside_half, n / 2.0, 8);
}

}  // namespace
}  // namespace sightline
