// Counts of verdicts, quantiles and confidence intervals.
#include "lab/tally.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <random>

namespace sightline {
namespace {

TEST(Quantiles, AreUpperBoundsWithinASixteenth) {
    Quantiles q;
    for (int i = 1; i <= 1000; ++i) q.add(i);
    EXPECT_GE(q.at(0.5), 500);
    EXPECT_LE(q.at(0.5), 500 * 17 / 16.0 + 1);
    EXPECT_GE(q.at(0.999), 999);
    EXPECT_EQ(q.at(1), 1000);
    EXPECT_EQ(q.max(), 1000);
}

TEST(Quantiles, DoNotDependOnTheOrderAndAreZeroIfEmpty) {
    Quantiles a, b, joined, whole;
    for (int i = 0; i < 100; ++i) (i % 3 ? a : b).add(i * 0.01), whole.add(i * 0.01);
    joined.add(b);
    joined.add(a);
    EXPECT_EQ(joined.at(0.7), whole.at(0.7));
    EXPECT_EQ(joined.count(), 100u);
    EXPECT_EQ(Quantiles().at(0.5), 0);
    Quantiles zeros;
    zeros.add(0);
    EXPECT_EQ(zeros.at(0.5), 0);
    zeros.add(NAN);
    zeros.add(INFINITY);
    EXPECT_EQ(zeros.count(), 3u);
}

TEST(Confidence, FollowsTheRuleOfThreeForNoEventAndWilsonOtherwise) {
    EXPECT_EQ(confidence_interval(0, 300).low, 0);
    EXPECT_DOUBLE_EQ(confidence_interval(0, 300).high, 0.01);
    EXPECT_EQ(confidence_interval(0, 2).high, 1);
    EXPECT_NEAR(confidence_interval(10, 100).low, 0.0552, 1e-4);  // Wilson 1927
    EXPECT_NEAR(confidence_interval(10, 100).high, 0.1744, 1e-4);
    EXPECT_EQ(confidence_interval(100, 100).high, 1);
    EXPECT_EQ(confidence_interval(0, 0).high, 1);
}

TEST(Tally, PrintsRatesPerMillionWithThreeDigits) {
    EXPECT_EQ(per_million({0, {0, 0}}), "0");
    EXPECT_EQ(per_million({0.1, {0.05519, 0.17437}}), "100,000 (55,200 to 174,000)");
    EXPECT_EQ(per_million({1.15e-4, {1.15e-4, 1.15e-4}}), "115");
    EXPECT_EQ(per_million({1.2345e-6, {0, 1.5e-5}}), "1.23 (0 to 15.0)");
}

Tally tally_of(uint64_t disagreeing_wrong, uint64_t disagreeing, uint64_t sampled_wrong,
               uint64_t sampled, uint64_t unchecked) {
    Tally tally;
    for (uint64_t i = 0; i < disagreeing + sampled; ++i)
        tally.count(i < disagreeing_wrong + sampled_wrong ? Verdict::missed : Verdict::same);
    tally.sampled = sampled;
    tally.sampled_wrong = sampled_wrong;
    tally.unchecked = unchecked;
    return tally;
}

TEST(Tally, GivesTheExactRateOfRaysThatAreAllChecked) {
    const Rate rate = tally_of(3, 10, 1, 30, 0).wrong_rate();
    EXPECT_DOUBLE_EQ(rate.estimate, 0.1);
    EXPECT_EQ(rate.bounds.low, rate.estimate);
    EXPECT_EQ(rate.bounds.high, rate.estimate);
}

TEST(Tally, WeightsASampleByTheRaysThatItStandsFor) {
    // 376 wrong answers, all among 400 rays on which engines differ; 1 ray in 50 of the others.
    const Rate rate = tally_of(376, 400, 0, 20'000, 979'600).wrong_rate();
    EXPECT_DOUBLE_EQ(rate.estimate, 376e-6);
    EXPECT_DOUBLE_EQ(rate.bounds.low, 376e-6);
    EXPECT_NEAR(rate.bounds.high, 376e-6 + 0.9996 * 3 / 20'000, 1e-9);
}

TEST(Tally, CoversTheTrueRateInNineteenOfTwentySamples) {
    std::mt19937 random(7);
    for (const double share : {0.002, 0.02, 0.3}) {
        // A population of 100,000 rays of which engines differ on 2,000, half of them wrong.
        const uint64_t agreeing = 98'000, differing = 2'000, sample = 2'000;
        int covered = 0;
        double sum = 0;
        constexpr int trials = 1000;
        const auto wrong = static_cast<uint64_t>(share * static_cast<double>(agreeing));
        const double truth = static_cast<double>(wrong + differing / 2) / 100'000;
        for (int i = 0; i < trials; ++i) {
            std::binomial_distribution<uint64_t> drawn(sample, share);
            const Rate rate =
                tally_of(differing / 2, differing, drawn(random), sample, agreeing - sample)
                    .wrong_rate();
            covered += rate.bounds.low <= truth && truth <= rate.bounds.high;
            sum += rate.estimate;
        }
        EXPECT_NEAR(sum / trials, truth, 0.02 * truth) << share;  // unbiased
        EXPECT_GE(covered, 930) << share;  // 950 − 3 standard deviations of 7
        EXPECT_LE(covered, 985) << share;
    }
}

TEST(Tally, CountsWrongAnswersAndExcludesUnjudgedRays) {
    Tally tally;
    for (size_t v = 0; v < verdicts; ++v) tally.count(static_cast<Verdict>(v));
    tally.unchecked = 5;
    tally.add(tally);
    EXPECT_EQ(tally.wrong(), 10u);
    EXPECT_EQ(tally.rays(), 30u);
    EXPECT_EQ(tally.judged(), 18u);
    const auto json = to_json(tally);
    for (const char* field :
         {"rays", "same", "tie", "near_tie", "missed", "false_hit", "wrong_primitive", "wrong_t",
          "wrong_uv", "undecidable", "unjudged", "unchecked", "wrong"})
        EXPECT_TRUE(json.contains(field)) << field;
    EXPECT_EQ(json["wrong"], 10);
    EXPECT_TRUE(json["t_ulps"].is_null());
}

TEST(Tally, MeasuresUlpsAtTheExactValue) {
    EXPECT_EQ(ulps_between(1 + 0x1p-23f, 1), 1);
    EXPECT_EQ(ulps_between(1, 1 + 0x1p-24), 0.5);
    EXPECT_EQ(ulps_between(2.0f, 2.0), 0);
}

TEST(Tally, RecognisesSelfHits) {
    const Ray ray = {{4, 1, 0}, 0, {0, 0.5f, 0}};
    EXPECT_TRUE(is_self_hit(ray, {64 * 0x1p-21f, 0, 0, 0, 0, 0}));
    EXPECT_FALSE(is_self_hit(ray, {65 * 0x1p-21f, 0, 0, 0, 0, 0}));
    EXPECT_FALSE(is_self_hit(ray, {}));
}

}  // namespace
}  // namespace sightline
