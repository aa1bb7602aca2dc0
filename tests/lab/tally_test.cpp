// Counts of verdicts, quantiles and confidence intervals.
#include "lab/tally.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

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
    EXPECT_EQ(per_million(0, 1000), "< 3/1000");
    EXPECT_EQ(per_million(0, 0), "–");
    EXPECT_EQ(per_million(10, 100), "1e+05 (5.52e+04 to 1.74e+05)");
}

TEST(Tally, CountsWrongAnswersAndExcludesUnjudgedRays) {
    Tally tally;
    for (size_t v = 0; v < verdicts; ++v) tally.count(static_cast<Verdict>(v));
    tally.unchecked = 5;
    tally.add(tally);
    EXPECT_EQ(tally.wrong(), 6u);
    EXPECT_EQ(tally.rays(), 26u);
    EXPECT_EQ(tally.judged(), 14u);
    const auto json = to_json(tally);
    for (const char* field : {"rays", "same", "tie", "near_tie", "missed", "false_hit",
                              "wrong_primitive", "undecidable", "unjudged", "unchecked", "wrong"})
        EXPECT_TRUE(json.contains(field)) << field;
    EXPECT_EQ(json["wrong"], 6);
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
