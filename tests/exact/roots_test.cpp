// The referee on analytic shapes: roots known by hand, touching rays, orders that floats cannot
// resolve.
#include "exact/shapes.h"
#include "intersect/shapes.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace sightline {
namespace {

constexpr float inf = std::numeric_limits<float>::infinity();

Ray ray_along(const Vec3& origin, const Vec3& direction, float tnear = 0, float tfar = inf) {
    return {origin, tnear, direction, tfar};
}

std::vector<ExactRoot> roots(const Ray& ray, const Shape& shape, const Mat4* placed = nullptr) {
    return exact_roots(ray, {&shape, placed}).value();
}

Shape make(ShapeKind kind) {
    Shape shape;
    shape.kind = kind;
    return shape;
}

TEST(ExactRoots, SphereThroughItsCentre) {
    const auto found = roots(ray_along({-2, 0, 0}, {1, 0, 0}), make(ShapeKind::sphere));
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].t, 1.5);
    EXPECT_EQ(found[1].t, 2.5);
}

TEST(ExactRoots, TangentIsOneDoubleRootAndOneUlpDecidesIt) {
    const Shape sphere = make(ShapeKind::sphere);
    const auto touching = roots(ray_along({-2, 0.5f, 0}, {1, 0, 0}), sphere);
    ASSERT_EQ(touching.size(), 1u);
    EXPECT_EQ(touching[0].t, 2);
    EXPECT_EQ(touching[0].multiplicity, 2);
    EXPECT_EQ(roots(ray_along({-2, std::nextafter(0.5f, 1.f), 0}, {1, 0, 0}), sphere).size(), 0u);
    EXPECT_EQ(roots(ray_along({-2, std::nextafter(0.5f, 0.f), 0}, {1, 0, 0}), sphere).size(), 2u);
}

TEST(ExactRoots, SegmentExcludesItsStartAndIncludesItsEnd) {
    const Shape sphere = make(ShapeKind::sphere);
    EXPECT_EQ(roots(ray_along({-0.5f, 0, 0}, {1, 0, 0}), sphere).size(), 1u);
    EXPECT_EQ(roots(ray_along({-0.5f, 0, 0}, {1, 0, 0}, 0, 1), sphere).size(), 1u);
    EXPECT_EQ(roots(ray_along({-0.5f, 0, 0}, {1, 0, 0}, 0, 0.999f), sphere).size(), 0u);
}

TEST(ExactRoots, CapsuleIsTheHullOfItsTwoSpheres) {
    Shape even = make(ShapeKind::capsule);  // height 1/2, radii 1/4
    const auto side = roots(ray_along({-2, 0.125f, 0}, {1, 0, 0}), even);
    ASSERT_EQ(side.size(), 2u);
    EXPECT_EQ(side[0].t, 1.75);
    EXPECT_EQ(side[1].t, 2.25);
    const auto axis = roots(ray_along({0, 2, 0}, {0, -1, 0}), even);
    ASSERT_EQ(axis.size(), 2u);
    EXPECT_EQ(axis[0].t, 1.5);
    EXPECT_EQ(axis[1].t, 2.5);
    EXPECT_EQ(roots(ray_along({-2, 0.25f, 0}, {1, 0, 0}), even).size(),
              2u);  // at their common circle
    EXPECT_EQ(roots(ray_along({-2, 0.5f, 0}, {1, 0, 0}), even).at(0).multiplicity, 2);
    Shape holding = even;  // the top sphere holds the other: a sphere about (0, 1/4, 0)
    holding.radius_top = 1;
    const auto ball = roots(ray_along({0, -2, 0}, {0, 1, 0}), holding);
    ASSERT_EQ(ball.size(), 2u);
    EXPECT_EQ(ball[0].t, 1.25);
    EXPECT_EQ(ball[1].t, 3.25);
}

TEST(ExactRoots, CapsulesOfAllProportionsAgreeWithTheSolverInDoubles) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> size(0.05f, 1), place(-2, 2);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        Shape shape = make(ShapeKind::capsule);
        shape.height = size(random);
        shape.radius_top = size(random);
        shape.radius_bottom = size(random);
        const Vec3 origin(place(random), place(random), place(random));
        const Ray ray =
            ray_along(origin, Vec3(place(random), place(random), place(random)) * 0.2f - origin);
        const auto exact = roots(ray, shape);
        const ShapeRoots solved =
            intersect_shape(shape, Vec3d(ray.origin), Vec3d(ray.direction), 0, double(inf));
        ASSERT_EQ(exact.size(), static_cast<size_t>(solved.count)) << i;
        for (size_t k = 0; k < exact.size(); ++k) EXPECT_NEAR(exact[k].t, solved.t[k], 1e-9) << i;
        hits += !exact.empty();
    }
    EXPECT_GT(hits, 1000);
}

TEST(ExactRoots, TorusHasFourAndTheTopPlaneTouchesTwice) {
    const Shape torus = make(ShapeKind::torus);  // R = 1/2, r = 1/4, axis y
    const auto four = roots(ray_along({-2, 0, 0}, {1, 0, 0}), torus);
    ASSERT_EQ(four.size(), 4u);
    const double expected[] = {1.25, 1.75, 2.25, 2.75};
    for (size_t i = 0; i < 4; ++i) EXPECT_EQ(four[i].t, expected[i]);
    const auto top = roots(ray_along({-2, 0.25f, 0}, {1, 0, 0}), torus);
    ASSERT_EQ(top.size(), 2u);
    EXPECT_EQ(top[0].t, 1.5);
    EXPECT_EQ(top[0].multiplicity, 2);
    EXPECT_EQ(top[1].t, 2.5);
    EXPECT_EQ(roots(ray_along({-2, 0, 0.25f}, {1, 0, 0}), torus).size(), 3u);  // inner circle
}

TEST(ExactRoots, HeartOnItsAxisAndItsTip) {
    const Shape heart = make(ShapeKind::heart);
    // On the y axis f = (y² − 1)³: triple roots at ±1.
    const auto axis = roots(ray_along({0, -3, 0}, {0, 1, 0}), heart);
    ASSERT_EQ(axis.size(), 2u);
    EXPECT_EQ(axis[0].t, 2);
    EXPECT_EQ(axis[0].multiplicity, 3);
    EXPECT_EQ(axis[1].t, 4);
    // y = 0: the ellipse x² + 9z²/4 = 1, again with triple roots.
    const auto waist = roots(ray_along({-3, 0, 0}, {1, 0, 0}), heart);
    ASSERT_EQ(waist.size(), 2u);
    EXPECT_EQ(waist[0].t, 2);
    EXPECT_EQ(waist[1].multiplicity, 3);
}

TEST(ExactRoots, BoxPlaneAndCone) {
    const auto box = roots(ray_along({-2, 0.5f, 0}, {1, 0, 0}), make(ShapeKind::box));
    ASSERT_EQ(box.size(), 2u);  // along the closed top face: in and out by the sides
    EXPECT_EQ(box[0].t, 1.5);
    EXPECT_EQ(roots(ray_along({0.5f, 1, 0}, {0, -1, 0}), make(ShapeKind::plane)).size(), 1u);
    EXPECT_EQ(roots(ray_along({0.6f, 1, 0}, {0, -1, 0}), make(ShapeKind::plane)).size(), 0u);
    Shape cone = make(ShapeKind::cylinder);
    cone.height = 2, cone.radius_bottom = 1, cone.radius_top = 0;
    const auto wall = roots(ray_along({-2, 0, 0}, {1, 0, 0}), cone);
    ASSERT_EQ(wall.size(), 2u);
    EXPECT_EQ(wall[0].t, 1.5);
    const auto through = roots(ray_along({0, 4, 0}, {0, -1, 0}), cone);  // apex and base
    ASSERT_EQ(through.size(), 2u);
    EXPECT_EQ(through[0].t, 3);
    EXPECT_EQ(through[1].t, 5);
}

/// A ray within a surface does not cross it, but it crosses the rims of other parts, as the solver
/// in doubles finds, too.
TEST(ExactRoots, ARayWithinASurfaceCrossesTheOtherParts) {
    EXPECT_EQ(roots(ray_along({-2, 0, 0}, {1, 0, 0}), make(ShapeKind::plane)).size(), 0u);
    Shape cone = make(ShapeKind::cylinder);
    cone.height = 2, cone.radius_bottom = 1, cone.radius_top = 0;
    Shape cylinder = make(ShapeKind::cylinder);
    cylinder.height = 2, cylinder.radius_bottom = cylinder.radius_top = 0.5f;
    Shape capsule = cylinder;
    capsule.kind = ShapeKind::capsule;
    const Ray down_the_cone = ray_along({-1, 3, 0}, {0.5f, -1, 0});
    const Ray along_the_mantle = ray_along({0.5f, -3, 0}, {0, 1, 0});
    const std::pair<Shape, Ray> cases[] = {
        {cylinder, along_the_mantle}, {capsule, along_the_mantle}, {cone, down_the_cone}};
    for (const auto& [shape, ray] : cases) {
        const auto found = roots(ray, shape);
        ASSERT_EQ(found.size(), 2u) << static_cast<int>(shape.kind);
        EXPECT_EQ(found[0].t, 2);
        EXPECT_EQ(found[1].t, 4);
        const ShapeRoots solved =
            intersect_shape(shape, Vec3d(ray.origin), Vec3d(ray.direction), 0, double(inf));
        ASSERT_EQ(solved.count, 2);
        EXPECT_EQ(solved.t[0], 2);
        EXPECT_EQ(solved.t[1], 4);
    }
}

TEST(ExactRoots, InstancesNeedNoInverseInFloat) {
    const Shape sphere = make(ShapeKind::sphere);
    Mat4 placed;
    placed[0][0] = -3;  // mirrored and stretched: the float inverse would be inexact
    placed[3][0] = 10;
    const auto found = roots(ray_along({0, 0, 0}, {1, 0, 0}), sphere, &placed);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].t, 8.5);
    EXPECT_EQ(found[1].t, 11.5);
    placed[0][0] = 0;
    EXPECT_FALSE(exact_roots(ray_along({0, 0, 0}, {1, 0, 0}), {&sphere, &placed}));
}

TEST(ExactRoots, IrrationalRootsAreTheNearestDoubles) {
    Shape sphere = make(ShapeKind::sphere);
    sphere.radius = 1;
    const auto found = roots(ray_along({0, 0, 0}, {1, 1, 0}), sphere);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].t, std::numbers::sqrt2 / 2);
}

/// Second derivation: the value of f changes sign between neighbouring roots of odd multiplicity.
TEST(ExactRoots, TorusIsInsideBetweenOddAndEvenRoots) {
    const Shape torus = make(ShapeKind::torus);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> number(-1, 1);
    const auto inside = [](const Vec3d& p) {
        const double ring = std::hypot(p.x, p.z) - 0.5;
        return ring * ring + p.y * p.y < 0.0625;
    };
    int crossings = 0;
    for (int i = 0; i < 2000; ++i) {
        const Ray ray = ray_along({number(random), number(random), number(random)},
                                  {number(random), number(random), number(random)});
        const auto at = [&](double t) { return Vec3d(ray.origin) + Vec3d(ray.direction) * t; };
        bool now = inside(at(0));
        double last = 0;
        for (const ExactRoot& root : roots(ray, torus)) {
            EXPECT_EQ(inside(at((last + root.t) / 2)), now);
            if (root.multiplicity % 2 == 1) now = !now;
            last = root.t;
            ++crossings;
        }
        EXPECT_FALSE(now);
    }
    EXPECT_GT(crossings, 500);
}

}  // namespace
}  // namespace sightline
