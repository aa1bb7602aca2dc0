// The referee on triangles and boxes: hand-worked cases, then a second derivation.
#include "exact/triangle.h"
#include "exact/boxes.h"

#include <gtest/gtest.h>

#include <random>

namespace sightline {
namespace {

constexpr float endless = std::numeric_limits<float>::infinity();
const InstancedTriangle unit = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

Ray down(float x, float y, float tnear = 0, float tfar = endless) {
    return {{x, y, 1}, tnear, {0, 0, -1}, tfar};
}

TEST(ExactTriangle, IsClosedAtEdgesAndVertices) {
    EXPECT_EQ(exact_crossing(down(0.25f, 0.25f), unit), Crossing::hit);
    EXPECT_EQ(exact_crossing(down(0.5f, 0.5f), unit), Crossing::hit);
    EXPECT_EQ(exact_crossing(down(0, 0), unit), Crossing::hit);
    EXPECT_EQ(exact_crossing(down(1, 0), unit), Crossing::hit);
    EXPECT_EQ(exact_crossing(down(std::nextafter(1.0f, 2.0f), 0), unit), Crossing::miss);
    EXPECT_EQ(exact_crossing(down(0, -0x1p-149f), unit), Crossing::miss);
}

TEST(ExactTriangle, SegmentExcludesItsStartAndIncludesItsEnd) {
    EXPECT_EQ(exact_crossing(down(0.25f, 0.25f, 0, 1), unit), Crossing::hit);
    EXPECT_EQ(exact_crossing(down(0.25f, 0.25f, 0, std::nextafter(1.0f, 0.0f)), unit),
              Crossing::miss);
    EXPECT_EQ(exact_crossing(down(0.25f, 0.25f, 1, 2), unit), Crossing::miss);
    EXPECT_EQ(exact_crossing({{0.25f, 0.25f, 0}, 0, {0, 0, -1}, endless}, unit), Crossing::miss);
}

/// Numbers of 22 bits, whose sums are floats and whose products of three are no doubles.
TEST(ExactTriangle, IsHitAtAVertexThatTheRayMeetsExactly) {
    std::mt19937 random(3);
    const auto vector = [&] {
        const auto coordinate = [&] {
            return (static_cast<float>(random() >> 10) - 0x1p21f) * 0x1p-11f;
        };
        const float x = coordinate(), y = coordinate();
        return Vec3(x, y, coordinate());
    };
    for (int i = 0; i < 2000; ++i) {
        const InstancedTriangle triangle = {vector(), vector(), vector()};
        const Vec3 vertex = i % 3 == 0 ? triangle.a : i % 3 == 1 ? triangle.b : triangle.c;
        const Vec3 d = vector(), o = vertex - d;
        ASSERT_EQ(o + d, vertex);
        EXPECT_EQ(exact_crossing({o, 0, d, 1}, triangle), Crossing::hit);
        EXPECT_EQ(exact_crossing({o, 1, d, endless}, triangle), Crossing::miss);
        EXPECT_EQ(exact_crossing({o, 0, d, std::nextafter(1.0f, 0.0f)}, triangle), Crossing::miss);
    }
}

TEST(ExactTriangle, RaysInItsPlaneAndTrianglesWithoutAreaAreEdgeOn) {
    EXPECT_EQ(exact_crossing({{-1, 0.25f, 0}, 0, {1, 0, 0}, endless}, unit), Crossing::edge_on);
    const InstancedTriangle line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    EXPECT_EQ(exact_crossing(down(0.5f, 0), line), Crossing::edge_on);
}

TEST(ExactTriangle, HitIsCorrectlyRounded) {
    // Plane x + y + z = 1 hit by the line from the origin along (1, 1, 1): t = 1/3.
    const InstancedTriangle tilted = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const ExactHit hit = exact_hit({{0, 0, 0}, 0, {1, 1, 1}, endless}, tilted);
    EXPECT_EQ(hit.t, 1.0 / 3.0);
    EXPECT_EQ(hit.u, 1.0 / 3.0);
    EXPECT_EQ(hit.v, 1.0 / 3.0);
    EXPECT_EQ(hit.normal.x, std::sqrt(1.0 / 3.0));
    EXPECT_EQ(exact_hit(down(0.25f, 0.5f), unit).u, 0.25);
    EXPECT_EQ(exact_hit(down(0.25f, 0.5f), unit).v, 0.5);
    EXPECT_EQ(exact_hit(down(0.25f, 0.5f), unit).normal, Vec3d(0, 0, 1));
}

TEST(ExactTriangle, OrdersPlanesThatDifferInTheLastBit) {
    InstancedTriangle lower = unit;
    EXPECT_EQ(compare_exactly(down(0.25f, 0.25f), unit, lower), 0);
    lower.a.z = -0x1p-149f;  // the plane dips below z = 0 by less than any double can resolve
    EXPECT_EQ(compare_exactly(down(0.25f, 0.25f), unit, lower), -1);
    EXPECT_EQ(compare_exactly(down(0.25f, 0.25f), lower, unit), 1);
}

TEST(ExactTriangle, MatrixTransformsItWithoutRounding) {
    Mat4 to_world;
    to_world[3][0] = 0x1p30f;  // a float vertex could not hold 2^30 + 1/4
    InstancedTriangle placed = {{0.25f, -1, -1}, {0.25f, 1, -1}, {0.25f, 0, 1}, &to_world};
    const Ray along = {{0, 0, 0}, 0, {1, 0, 0}, endless};
    EXPECT_EQ(exact_hit(along, placed).t, 0x1p30 + 0.25);
    placed.a.x = placed.b.x = placed.c.x = 0.5f;
    EXPECT_EQ(
        compare_exactly(along, placed, {{0.25f, -1, -1}, {0.25f, 1, -1}, {0.25f, 0, 1}, &to_world}),
        1);
}

TEST(ExactTriangle, OnlyCasesThatOneUlpCanChangeAreUndecidable) {
    EXPECT_TRUE(decidable_at_float(down(0.25f, 0.25f), unit));
    EXPECT_TRUE(decidable_at_float(down(0.5f, 0.6f), unit));
    EXPECT_FALSE(decidable_at_float(down(0.5f, 0.5f), unit));
    EXPECT_FALSE(decidable_at_float(down(0.5f, std::nextafter(0.5f, 1.0f)), unit));
    EXPECT_TRUE(decidable_at_float(down(0.5f, 0.5f + 0x1p-21f), unit));
}

/// A float of few bits, so that exact coincidences are common.
struct Coarse {
    std::mt19937 random{7};
    float operator()() { return static_cast<float>(static_cast<int>(random() % 9) - 4); }
    Vec3 vector() { return {(*this)(), (*this)(), (*this)()}; }
};

/// Barycentrics by Cramer's rule over 64-bit integers: another formula, other arithmetic.
Crossing by_cramer(const Ray& ray, const InstancedTriangle& triangle) {
    using V = Imath::Vec3<int64_t>;
    const auto integer = [](const Vec3& v) {
        return V(static_cast<int64_t>(v.x), static_cast<int64_t>(v.y), static_cast<int64_t>(v.z));
    };
    const V o = integer(ray.origin), d = integer(ray.direction), a = integer(triangle.a);
    const V e = integer(triangle.b) - a, f = integer(triangle.c) - a, s = o - a;
    int64_t det = dot(e, cross(d, f));
    if (det == 0) return Crossing::edge_on;
    int64_t u = dot(s, cross(d, f)), v = dot(d, cross(s, e)), t = dot(f, cross(s, e));
    if (det < 0) det = -det, u = -u, v = -v, t = -t;
    return u >= 0 && v >= 0 && u + v <= det && t > 0 ? Crossing::hit : Crossing::miss;
}

TEST(ExactTriangle, AgreesWithCramersRuleOnIntegers) {
    Coarse coarse;
    int hits = 0, touching = 0;
    for (int i = 0; i < 20000; ++i) {
        const Ray ray = {coarse.vector(), 0, coarse.vector(), endless};
        const InstancedTriangle triangle = {coarse.vector(), coarse.vector(), coarse.vector()};
        if (!has_exact_answer(ray)) continue;
        const Crossing expected = by_cramer(ray, triangle), found = exact_crossing(ray, triangle);
        hits += found == Crossing::hit;
        touching += found == Crossing::hit && !decidable_at_float(ray, triangle);
        if (expected == Crossing::edge_on)
            EXPECT_NE(found, Crossing::hit);
        else
            EXPECT_EQ(found, expected) << i;
    }
    EXPECT_GT(hits, 500);
    EXPECT_GT(touching, 100);  // the coincidences that only exact arithmetic settles
}

/// Rays through a triangle of a mesh near the origin, in instances of every kind.
TEST(ExactTriangle, PlaneHitsOfInstancesAreTheExactOnesToThirtyBits) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> number(-1, 1);
    const auto point = [&] { return Vec3(number(random), number(random), number(random)); };
    const float scales[] = {1, 1e-3f, 1e-12f, 1e4f, -1};
    const float places[] = {0, 1, 1e3f};
    int checked = 0;
    for (int i = 0; i < 6000; ++i) {
        const float scale = scales[i % 5], place = places[i % 3];
        Mat4 m;
        for (int r = 0; r < 4; ++r)
            for (int c = 0; c < 3; ++c) m[r][c] = number(random) * (r < 3 ? scale : place);
        if (i % 7 == 0)
            for (int c = 0; c < 3; ++c) m[2][c] = m[1][c] * (1 + 0x1p-20f);  // almost flat
        const InstancedTriangle triangle = {point(), point(), point(), &m};
        const Vec3 centre = (triangle.a + triangle.b * 2 + triangle.c) * 0.25f * m;
        const Vec3 origin = point() * 5;
        const Ray ray = {origin, 0, centre - origin, endless};
        if (exact_crossing(ray, triangle) != Crossing::hit) continue;
        const PlaneHit hit = plane_hit(ray, triangle);
        const ExactHit exact = exact_hit(ray, triangle);
        ++checked;
        EXPECT_NEAR(hit.t, exact.t, 0x1p-30 * std::abs(exact.t)) << i;
        // u and v are quotients of a product of three lengths and the determinant.
        Mat4d linear(m);
        for (int c = 0; c < 3; ++c) linear[3][c] = 0;
        const Vec3d ab = (Vec3d(triangle.b) - Vec3d(triangle.a)) * linear,
                    ac = (Vec3d(triangle.c) - Vec3d(triangle.a)) * linear, d(ray.direction);
        const double lengths =
            (std::abs(place) * 4 + 10) * d.length() * (ab.length() + ac.length());
        const double allowed = 0x1p-49 * lengths / std::abs(dot(cross(ab, ac), d)) + 0x1p-30;
        EXPECT_NEAR(hit.u, exact.u, allowed) << i;
        EXPECT_NEAR(hit.v, exact.v, allowed) << i;
    }
    EXPECT_GT(checked, 3000);
}

TEST(ExactBox, ZeroDirectionsOnASlabsPlaneTouchTheClosedBox) {
    const Box3 box({-1, -2, -3}, {1, 2, 3});
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f})
            for (const float zero : {0.0f, -0.0f}) {
                Ray ray = {{0, 0, 0}, 0, {1, 1, 1}, endless};
                ray.origin[axis] = side > 0 ? box.max[axis] : box.min[axis];
                ray.direction[axis] = zero;
                EXPECT_TRUE(exact_box_crossing(ray, box));
                ray.origin[axis] = std::nextafter(ray.origin[axis], side * endless);
                EXPECT_FALSE(exact_box_crossing(ray, box));
            }
}

TEST(ExactBox, CornersEndsAndEmptyBoxes) {
    const Box3 box({0, 0, 0}, {1, 1, 1});
    EXPECT_TRUE(exact_box_crossing({{2, 0, 0}, 0, {-1, 1, 1}, endless}, box));  // through (1,1,1)
    EXPECT_FALSE(
        exact_box_crossing({{2, 0, 0}, 0, {-1, std::nextafter(1.0f, 2.0f), 1}, endless}, box));
    EXPECT_TRUE(exact_box_crossing({{-1, 0.5f, 0.5f}, 0, {1, 0, 0}, 1}, box));
    EXPECT_FALSE(exact_box_crossing({{-1, 0.5f, 0.5f}, 0, {1, 0, 0}, 0.999f}, box));
    EXPECT_FALSE(exact_box_crossing({{0.5f, 0.5f, 0.5f}, 0, {1, 0, 0}, endless}, Box3()));
}

}  // namespace
}  // namespace sightline
