// The atlas: its exact answers on cases solved by hand, its known findings, and its
// reproducibility.
#include "core/error.h"
#include "exact/refraction.h"
#include "lab/atlas/atlas_report.h"
#include "support/atlas_scores.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <bit>
#include <set>

namespace sightline {
namespace {

AtlasOptions small(std::vector<std::string> families, std::vector<std::string> methods,
                   size_t rays) {
    return {std::move(families), std::move(methods), rays, 1, 1, false};
}

TEST(Atlas, AnUnknownNameIsAnErrorThatListsAllNames) {
    try {
        run_atlas(small({"T9"}, {}, 1));
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("'T9'"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("T1v"), std::string::npos);
    }
    try {
        run_atlas(small({}, {"embre"}, 1));
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("'embre'"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("sphere-haines-double"), std::string::npos);
    }
}

TEST(Atlas, TheSameSeedGivesTheSameResultsExceptForTimes) {
    const auto options = small({"T1v", "B1", "S2"}, {}, 50);
    const auto stripped = [&](const AtlasOptions& o) {
        auto json = atlas_json(run_atlas(o), o, 1);
        EXPECT_EQ(json["summary"].size(), 3u);
        json["summary"].erase(2);  // who is fastest
        for (auto& family : json["families"])
            for (auto& knob : family["knobs"])
                for (auto& method : knob["methods"]) method.erase("ns_per_ray");
        return json.dump();
    };
    const std::string first = stripped(options);
    EXPECT_EQ(first, stripped(options));
    AtlasOptions other = options;
    other.seed = 2;
    EXPECT_NE(first, stripped(other));
}

TEST(Atlas, TheBestMethodsAreNeverWrong) {
    std::set<std::string> best;
    for (const Family& family : atlas_families())
        for (const std::string& method : family.methods)
            if (is_best_method(method)) best.insert(method);
    EXPECT_EQ(best.size(), 8u);
    constexpr size_t rays = SIGHTLINE_SANITIZED ? 10 : 50;  // sanitizers are thirty times slower
    for (const FamilyScore& family : run_atlas(small({}, {best.begin(), best.end()}, rays)))
        for (const KnobScore& knob : family.knobs)
            for (const MethodScore& method : knob.methods)
                EXPECT_EQ(method.wrong, 0u)
                    << family.family->name << ' ' << knob.knob.value << ' ' << method.method;
}

TEST(Atlas, TheSummaryLeavesOutValuesThatAreNotFinite) {
    EXPECT_FALSE(summary_of({NAN, INFINITY}));
    const auto summary = summary_of({3, 1, NAN, 2});
    ASSERT_TRUE(summary);
    EXPECT_EQ(summary->median, 2);
    EXPECT_EQ(summary->max, 3);
}

TEST(AtlasMeasures, SeparateTheConditioningFromTheMethodsError) {
    // Straight down from height 4 to z = 0: t = 4 depends only on the z of origin and direction.
    const SurfaceCrossing crossing({{1, 2, 4}, 0, {0, 0, -1}}, 4, {0, 0, 1});
    EXPECT_EQ(crossing.condition(), 2);  // (4 + 4)/4
    const Measures measures = crossing.measure(4 + 0x1p-20);
    EXPECT_EQ(measures.t_ulps, 2);     // an ulp of 4 is 2^-21
    EXPECT_EQ(measures.backward, 2);   // 4 is also the largest coordinate
    EXPECT_EQ(measures.stability, 2);  // 2^-20/(8·2^-24)
    EXPECT_TRUE(std::isnan(measures.gap));
}

TEST(AtlasFamilies, KnobValuesAscendAndRaysHitExceptAfterBounces) {
    for (const Family& family : atlas_families()) {
        double last = -1;
        for (const KnobValue& knob : family.values) {
            EXPECT_GT(knob.value, last) << family.name;
            last = knob.value;
        }
        const Experiment experiment = family.make({family.values.front().value, 300, 7});
        ASSERT_EQ(experiment.size, 300u);
        size_t hits = 0;
        for (size_t i = 0; i < experiment.size; ++i) hits += experiment.hits[i];
        const bool bounces = family.name.starts_with("N");  // here a hit is an error
        EXPECT_EQ(hits > 50, !bounces) << family.name;
    }
}

TEST(AtlasFamilies, AreTheSameForTheSameSeed) {
    const Family& family = family_named("S2");
    // A condition number depends on every bit of a case's input.
    const auto bits = [&](uint64_t seed) {
        std::vector<uint64_t> result;
        for (const double c : family.make({1000, 100, seed}).conditions)
            result.push_back(std::bit_cast<uint64_t>(c));
        return result;
    };
    EXPECT_EQ(bits(3), bits(3));
    EXPECT_NE(bits(3), bits(4));
}

TEST(AtlasFindings, EmbreesModesLoseVerticesAndOnlyTheDefaultLosesEdges) {
    auto vertex =
        scores_at("T1v", 100, {"embree", "embree-default", "exact", "moller-trumbore"}, 2000);
    EXPECT_NEAR(vertex["embree-default"].lost(), 0.23, 0.08);
    EXPECT_GT(vertex["embree"].lost(), 0);
    EXPECT_LT(vertex["embree"].lost(), 0.05);
    EXPECT_NEAR(vertex["moller-trumbore"].lost(), 0.17, 0.06);
    EXPECT_EQ(vertex["exact"].wrong(), 0);
    auto edge = scores_at("T1e", 100, {"embree", "embree-default", "plane-inside"}, 2000);
    EXPECT_NEAR(edge["embree-default"].lost(), 0.09, 0.05);
    EXPECT_EQ(edge["embree"].lost(), 0);
    EXPECT_NEAR(edge["plane-inside"].lost(), 0.15, 0.06);
}

TEST(AtlasFindings, NaiveSpheresFailOnFourRaysOfTenAtTwentyThousandRadii) {
    auto scores = scores_at("S1", 2e4, {"sphere-quadratic", "sphere-haines", "analytic"}, 1000);
    EXPECT_NEAR(scores["sphere-quadratic"].wrong(), 0.42, 0.06);
    EXPECT_LT(scores["sphere-haines"].wrong(), 0.003);
    EXPECT_EQ(scores["analytic"].wrong(), 0);
}

TEST(AtlasFindings, UnpaddedSlabsLoseCorners) {
    auto scores = scores_at("B1", 10, {"box-reciprocal", "box-division", "box-conservative"}, 4000);
    EXPECT_GT(scores["box-reciprocal"].lost(), 0.01);
    EXPECT_GT(scores["box-division"].lost(), 0.001);
    EXPECT_EQ(scores["box-conservative"].lost(), 0);
}

TEST(AtlasFindings, AFixedEpsilonHitsItsOwnSurfaceFarOutAndTheErrorBoundIsTighterThanIntegers) {
    auto scores = scores_at("N1", 1e4, family_named("N1").methods, 2000);
    EXPECT_NEAR(scores["offset-none"].wrong(), 0.5, 0.1);
    EXPECT_GT(scores["offset-normal-1e-4"].wrong(), 0.3);
    EXPECT_EQ(scores["offset-bound"].wrong(), 0);
    EXPECT_GT(scores["offset-wachter-binder"].median_gap, 5 * scores["offset-bound"].median_gap);
}

TEST(AtlasFindings, CountingHitsFailsAtVerticesAndEdges) {
    auto scores = scores_at("P1", 100, {"parity", "winding-number", "plucker", "woop"}, 500);
    EXPECT_EQ(scores["parity"].wrong(), 0);
    EXPECT_EQ(scores["winding-number"].wrong(), 0);
    EXPECT_GT(scores["plucker"].wrong(), 0.2);  // both triangles at an edge count
    EXPECT_GT(scores["woop"].wrong(), 0.04);
}

TEST(AtlasFindings, MarchingMissesDoubleRoots) {
    auto scores = scores_at("Q2", 1e7, {"analytic", "implicit-marching-double"}, 200);
    EXPECT_EQ(scores["analytic"].wrong(), 0);
    EXPECT_GT(scores["implicit-marching-double"].wrong(), 0.15);
}

TEST(AtlasFindings, TheExactTreeGivesTheSameBitsOnEveryInstructionSetAndEmbreeDoesNot) {
    const auto scores = run_atlas(small({"V1"}, {"exact", "embree"}, 1500));
    std::set<uint64_t> exact, embree;
    for (const KnobScore& knob : scores.front().knobs) {
        embree.insert(knob.methods[0].hash);
        exact.insert(knob.methods[1].hash);
    }
    EXPECT_EQ(exact.size(), 1u);
    // Processors of the last ten years have at least three instruction sets that differ.
    if (scores.front().knobs.size() > 6) {
        EXPECT_GT(embree.size(), 1u);
    }
}

TEST(AtlasFindings, TheExactTreeLosesNoRayFromInsideAClosedMesh) {
    auto scores = scores_at("T5", 0, {"exact"}, 5000);
    EXPECT_EQ(scores["exact"].wrong(), 0);
}

TEST(ExactRefraction, AgreesWithCasesSolvedByHand) {
    // eta² − 1 + c² = 1/4 − 1 + 49/64 = 1/64: eta·cos_t = 1/8.
    const ExactRefraction r = exact_refraction(0.875f, 0.5f);
    EXPECT_FALSE(r.total);
    EXPECT_EQ(r.cos_t, 0.25);
    EXPECT_NEAR(r.reflectance, 0.5 * (9.0 / 16 + 9.0 / 121), 1e-15);
    EXPECT_TRUE(exact_refraction(0.5f, 0.5f).total);
    // Along the boundary of two equal media, the radicand is exactly zero.
    EXPECT_TRUE(exact_refraction(0, 1).total);
    EXPECT_FALSE(exact_refraction(0x1p-149f, 1).total);
    EXPECT_NEAR(exact_refraction(1, 1.5f).reflectance, 0.04, 1e-15);
}

}  // namespace
}  // namespace sightline
