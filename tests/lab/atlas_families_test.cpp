// Families of the atlas with more than one surface or ray: nested nodes, media in contact, mirrors
// that face each other.
#include "exact/triangle.h"
#include "lab/atlas/rng.h"
#include "support/atlas_scores.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

Mat4 moved_by(const Vec3& offset) {
    Mat4 m;
    for (int i = 0; i < 3; ++i) m[3][i] = offset[i];
    return m;
}

TEST(NestedTriangle, ComposesTransformsWithoutRounding) {
    const std::array<Vec3, 3> corners = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
    Mat4 third;
    third[0][0] = third[1][1] = third[2][2] = 0x1.555556p-2f;
    const Mat4 there = moved_by({0x1p60f, 0, 0}), back = moved_by({-0x1p60f, 0, 0});
    const NestedTriangle nested(corners, std::array{there, third, back});
    const Ray down = {{0.25f, 0.25f, 1}, 0, {0, 0, -1}};
    EXPECT_EQ(nested.crossing(down), Crossing::miss);  // the scale applies to `there` only
    const NestedTriangle returned(corners, std::array{there, back, third});
    EXPECT_EQ(returned.corners()[1], Vec3d(0x1.555556p-2, 0, 0));
    const NestedTriangle twice(corners, std::array{moved_by({2, 0, 0}), third});
    EXPECT_EQ(twice.corners()[0], Vec3d(0x1.555556p-1, 0, 0));  // the innermost node first
    EXPECT_EQ(returned.crossing({{0.125f, 0.125f, 1}, 0, {0, 0, -1}}), Crossing::hit);
    EXPECT_EQ(returned.crossing(down), Crossing::miss);
    // The edge x + y = 1/3: at 0x1.555556p-2 exactly, and one ulp beyond.
    const float edge = 0x1.555556p-2f;
    EXPECT_EQ(returned.crossing({{edge, 0, 1}, 0, {0, 0, -1}}), Crossing::hit);
    EXPECT_EQ(returned.crossing({{std::nextafter(edge, 1.0f), 0, 1}, 0, {0, 0, -1}}),
              Crossing::miss);
}

TEST(NestedTriangle, UnderOneNodeEqualsAnInstancedTriangle) {
    Rng rng(5);
    for (int i = 0; i < 200; ++i) {
        const std::array<Vec3, 3> corners = {Vec3(rng.in_cube(1)), Vec3(rng.in_cube(1)),
                                             Vec3(rng.in_cube(1))};
        Mat4 m;
        for (int row = 0; row < 4; ++row)
            for (int column = 0; column < 3; ++column)
                m[row][column] = static_cast<float>(rng.uniform(-1, 1));
        const InstancedTriangle placed = {corners[0], corners[1], corners[2], &m};
        const NestedTriangle nested(corners, {&m, 1});
        const Vec3d target = (Vec3d(corners[0]) + Vec3d(corners[1]) + Vec3d(corners[2])) / 3;
        const Ray ray = aimed_ray(rng.in_cube(3), transform_point(target, Mat4d(m)), rng);
        ASSERT_EQ(nested.crossing(ray), exact_crossing(ray, placed));
        EXPECT_EQ(nested.crossing(ray), Crossing::hit);
        EXPECT_EQ(nested.hit(ray).t, exact_hit(ray, placed).t);
    }
}

TEST(AtlasFindings, NestedNodesNeedProductsInDouble) {
    auto scores = scores_at("X2", 256, family_named("X2").methods, 500);
    EXPECT_EQ(scores["nodes-baked"].wrong(), 0);
    EXPECT_EQ(scores["nodes-instanced"].wrong(), 0);
    EXPECT_NEAR(scores["nodes-float-product"].wrong(), 0.05, 0.04);
    EXPECT_NEAR(scores["nodes-float-steps"].wrong(), 0.05, 0.04);
}

TEST(AtlasFindings, WalksLoseOneOfTwoCoincidentSurfacesAndParityDoesNot) {
    for (const char* family : {"R3g", "R3o"}) {
        auto apart = scores_at(family, 1e5, family_named(family).methods, 150);
        EXPECT_EQ(apart["walk-rendered"].wrong(), 0) << family;
        EXPECT_EQ(apart["walk-exact-tree"].wrong(), 0) << family;
        EXPECT_GT(apart["walk-tnear-1e-4"].wrong(), 0.5) << family;
        auto touching = scores_at(family, 1e9, {"parity", "winding-number", "walk-rendered"}, 150);
        EXPECT_GT(touching["walk-rendered"].wrong(), 0.3) << family;
        EXPECT_EQ(touching["parity"].wrong(), 0) << family;
        EXPECT_EQ(touching["winding-number"].wrong(), 0) << family;
    }
}

TEST(AtlasFindings, RendersNeedDepth128BetweenMirrorsToStayWithinTheCutoff) {
    auto scores = scores_at("R4", 8, family_named("R4").methods, 100);
    EXPECT_EQ(scores["render-depth-8"].lost(), 1);
    EXPECT_EQ(scores["render-depth-32"].lost(), 1);
    EXPECT_EQ(scores["render-depth-128"].wrong(), 0);
    EXPECT_EQ(scores["render-depth-512"].wrong(), 0);
    // The partial sum at depth 2, for each pixel.
    const Experiment experiment = family_named("R4").make({8, 100, 1});
    const MethodRun run = experiment.prepare("render-depth-2");
    run.run();
    for (size_t i = 0; i < 100; ++i) {
        const double r = 1 - 1 / experiment.conditions[i];
        EXPECT_NEAR(run.answer(i).t, 1 + r + r * r, 1e-6);
    }
}

}  // namespace
}  // namespace sightline
