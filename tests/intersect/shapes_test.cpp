#include "intersect/shapes.h"
#include "intersect/shape_surface.h"

#include "exact/shapes.h"
#include "intersect/roots.h"
#include "support/shapes.h"

#include <gtest/gtest.h>
#include <algorithm>

namespace sightline {
namespace {

void expect_roots(const std::vector<double>& found, const std::vector<double>& expected,
                  double tolerance = 1e-12) {
    ASSERT_EQ(found.size(), expected.size());
    for (size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], tolerance);
}

TEST(Shapes, ASphereHasAnEntryAndAnExit) {
    const Shape s = make_shape(ShapeKind::sphere);
    expect_roots(roots(s, {0, 0, 2}, {0, 0, -1}), {1.5, 2.5});
    expect_roots(roots(s, {0, 0, 2}, {0, 0, -4}), {0.375, 0.625});
    expect_roots(roots(s, {0, 0, 0}, {0, 1, 0}), {0.5});
    expect_roots(roots(s, {0, 0, 2}, {0, 0, 1}), {});
    expect_roots(roots(s, {0, 0, 2}, {0, 0, -1}, 1.6, 3), {2.5});
}

TEST(Shapes, ATangentRayTouchesASphereOnceWithMultiplicityTwo) {
    const Shape s = make_shape(ShapeKind::sphere);
    expect_roots(roots(s, {0.5, 0, 2}, {0, 0, -1}), {2, 2});
    expect_roots(roots(s, {std::nextafter(0.5, 1), 0, 2}, {0, 0, -1}), {});
}

TEST(Shapes, ABoxIsHitAtItsFacesEdgesAndCorners) {
    Shape s = make_shape(ShapeKind::box);
    s.size = Vec3(2, 4, 6);
    expect_roots(roots(s, {0, 0, 9}, {0, 0, -1}), {6, 12});
    expect_roots(roots(s, {1, 2, 9}, {0, 0, -1}), {6, 12});
    expect_roots(roots(s, {2, 4, 6}, {-1, -2, -3}), {1, 3});
    expect_roots(roots(s, {1.0001, 0, 9}, {0, 0, -1}), {});
}

TEST(Shapes, ACylinderIsClosedByItsCaps) {
    const Shape s = cylinder(0.5f, 0.5f, 2);
    expect_roots(roots(s, {2, 0.9, 0}, {-1, 0, 0}), {1.5, 2.5});
    expect_roots(roots(s, {0.25, 3, 0}, {0, -1, 0}), {2, 4});
    expect_roots(roots(s, {0.5, 3, 0}, {0, -1, 0}), {2, 4});
    expect_roots(roots(s, {1.5, 2, 0}, {-1, -1, 0}), {1, 2});  // by the rim's edge, out by the side
    expect_roots(roots(s, {2, 1.1, 0}, {-1, 0, 0}), {});
}

TEST(Shapes, AConeHasOneApexAndNoSecondNappe) {
    const Shape s = cylinder(1, 0, 2);
    expect_roots(roots(s, {-3, 0, 0}, {1, 0, 0}), {2.5, 3.5});
    expect_roots(roots(s, {0, 5, 0}, {0, -1, 0}), {4, 6});
    expect_roots(roots(s, {-3, 1.5, 0}, {1, 0, 0}), {});
    expect_roots(roots(s, {-2, -1, 0.5}, {1, 1.5, 0}), roots(s, {2, -1, 0.5}, {-1, 1.5, 0}));
}

TEST(Shapes, ACapsuleIsClosedByItsTwoSpheres) {
    Shape s = make_shape(ShapeKind::capsule);
    s.height = 2;
    s.radius_top = 0.5f;
    s.radius_bottom = 1;
    expect_roots(roots(s, {0, 9, 0}, {0, -1, 0}), {7.5, 11});
    expect_roots(roots(s, {9, -1, 0}, {-1, 0, 0}), {8, 10}, 0.04);
    s.radius_bottom = 4;  // holds the other
    expect_roots(roots(s, {0, 9, 0}, {0, -1, 0}), {6, 14});
    s.radius_bottom = s.radius_top;
    expect_roots(roots(s, {9, 0.3, 0}, {-1, 0, 0}), {8.5, 9.5});
}

TEST(Shapes, APlaneCanBeUnbounded) {
    Shape s = make_shape(ShapeKind::plane);
    expect_roots(roots(s, {0.5, 1, 0.5}, {0, -1, 0}), {1});
    expect_roots(roots(s, {0.6, 1, 0}, {0, -1, 0}), {});
    s.size = Vec3(0, 0, 0);
    expect_roots(roots(s, {6e7, 1, 0}, {0, -1, 0}), {1});
    expect_roots(roots(s, {0, 1, 0}, {1, 0, 0}), {});
    expect_roots(roots(s, {0, 0, 0}, {1, 0, 0}), {});
}

TEST(Shapes, ATorusIsCrossedFourTimesAlongItsPlane) {
    const Shape s = torus(1, 0.25f);
    expect_roots(roots(s, {-3, 0, 0}, {1, 0, 0}), {1.75, 2.25, 3.75, 4.25});
    expect_roots(roots(s, {0, 0, 0}, {1, 0, 0}), {0.75, 1.25});
    expect_roots(roots(s, {0, 3, 0}, {0, -1, 0}), {});
    expect_roots(roots(s, {1, 3, 0}, {0, -1, 0}), {2.75, 3.25});
}

TEST(Shapes, ATorusIsTouchedByPlanesOnItsTopAndInItsHole) {
    const Shape s = torus(1, 0.25f);
    expect_roots(roots(s, {-3, 0.25, 0}, {1, 0, 0}), {2, 2, 4, 4}, 1e-7);
    expect_roots(roots(s, {0.75, 3, 0}, {0, -1, 0}), {3, 3}, 1e-7);
    // A Villarceau circle's plane: the ray through the centre touches the tube twice.
    const double sine = 0.25, cosine = std::sqrt(1 - sine * sine);
    const double touch = std::sqrt(1 - 0.0625);
    expect_roots(roots(s, Vec3d(-2 * cosine, -2 * sine, 0), {cosine, sine, 0}),
                 {2 - touch, 2 - touch, 2 + touch, 2 + touch}, 1e-7);
}

TEST(Shapes, AHeartPointsDownAndIsDentedAbove) {
    const Shape s = make_shape(ShapeKind::heart);
    expect_roots(roots(s, {0, -3, 0}, {0, 1, 0}), {2, 4}, 1e-7);
    expect_roots(roots(s, {-3, 0, 0}, {1, 0, 0}), {2, 4});  // the equator: triple roots
    expect_roots(roots(s, {0, 0, -3}, {0, 0, 1}), {7.0 / 3, 11.0 / 3});
    EXPECT_EQ(roots(s, {-3, 1.1, 0}, {1, 0, 0}).size(), 4u);  // through both lobes
    EXPECT_EQ(roots(s, {-3, -0.9, 0}, {1, 0, 0}).size(), 2u);
    EXPECT_EQ(roots(s, {-3, 1.3, 0}, {1, 0, 0}).size(), 0u);
}

TEST(Shapes, MatricesTranslateRotateAndScaleThem) {
    const Mat4d m = Mat4d().setScale(Vec3d(2, 4, 6)) * Mat4d().setTranslation(Vec3d(10, 0, 0));
    const Shape s = make_shape(ShapeKind::sphere, m);
    expect_roots(roots(s, {0, 0, 0}, {1, 0, 0}), {9, 11});
    expect_roots(roots(s, {10, 9, 0}, {0, -3, 0}), {7.0 / 3, 11.0 / 3});
    const Box3 b = shape_bounds(s);
    EXPECT_NEAR(b.min.x, 9, 1e-5);
    EXPECT_NEAR(b.max.y, 2, 1e-5);
    EXPECT_LE(b.min.x, 9);
    EXPECT_GE(b.max.z, 3);
}

TEST(Shapes, InvalidRaysHitNothing) {
    for (const Shape& s : one_of_each()) {
        expect_roots(roots(s, {0, 0, 0}, {0, 0, 0}), {});
        expect_roots(roots(s, {NAN, 0, 0}, {1, 1, 1}), {});
        expect_roots(roots(s, {0, 0, 0}, {NAN, 1, 1}), {});
        expect_roots(roots(s, {0, 0, 0}, {infinity, 1, 1}), {});
        expect_roots(roots(s, {0, infinity, 0}, {1, 1, 1}), {});
    }
}

/// Every change of sign that a fine march in long double sees has its root, and no root lacks one.
TEST(Shapes, RootsAreWhereTheSurfaceChangesSign) {
    RandomRays random;
    for (const Shape& s : one_of_each()) {
        for (int i = 0; i < 300; ++i) {
            const Vec3d d = random.direction(i);
            const Vec3d o = random.inside() - d * 3;
            const std::vector<double> found = roots(s, o, d);
            const auto at = [&](double t) {
                const long double l = t;
                return implicit(s, o.x + l * d.x, o.y + l * d.y, o.z + l * d.z);
            };
            constexpr int steps = 4000;
            constexpr double length = 8;
            std::vector<std::pair<double, double>> changes;
            for (int k = 0; k < steps; ++k) {
                const double a = length * k / steps, b = length * (k + 1) / steps;
                if ((at(a) < 0) != (at(b) < 0)) changes.push_back({a - 1e-9, b + 1e-9});
            }
            const bool bounded = s.kind != ShapeKind::plane;
            if (bounded) {
                EXPECT_EQ(found.size() % 2, 0u);
                EXPECT_GE(found.size(), changes.size());
                for (const auto& change : changes)
                    EXPECT_TRUE(std::any_of(
                        found.begin(), found.end(),
                        [&](double t) { return t >= change.first && t <= change.second; }))
                        << "kind " << int(s.kind) << " ray " << i;
            }
            EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
            for (const double t : found) EXPECT_NEAR(double(at(t)), 0, 4e-14) << int(s.kind);
        }
    }
}

TEST(Shapes, DistantOriginsChangeNeitherDecisionNorDigits) {
    RandomRays random;
    for (const Shape& s : one_of_each()) {
        for (const double distance : {1e2, 1e4, 1e6}) {
            for (int i = 1; i < 200; ++i) {
                const Vec3d d = random.direction(i), o = random.inside();
                const std::vector<double> near = roots(s, o, d, -infinity);
                const std::vector<double> far = roots(s, o - d * distance, d, -infinity);
                double closest_pair = 1;
                for (size_t k = 1; k < near.size(); ++k)
                    closest_pair = std::min(closest_pair, near[k] - near[k - 1]);
                if (closest_pair < 1e-3 || near.empty()) continue;  // nearly tangent
                ASSERT_EQ(near.size(), far.size()) << int(s.kind) << " " << distance;
                for (size_t k = 0; k < near.size(); ++k)
                    EXPECT_NEAR(far[k] - distance, near[k], 1e-12 * distance);
            }
        }
    }
}

/// Random rays, and rays aimed along the surface itself, from three distances.
TEST(Shapes, HaveTheRootsOfExactArithmetic) {
    RandomRays random;
    for (const Shape& s : one_of_each()) {
        for (int i = 0; i < 300; ++i) {
            const double distance = i % 3 == 0 ? 3 : i % 3 == 1 ? 1e3 : 1e6;
            Vec3d d = random.direction(3 * i + 1), target = random.inside();
            const std::vector<double> aimed = roots(s, target - d * 3, d);
            if (i % 2 == 0 && !aimed.empty()) {
                const ShapePoint p = shape_point(s, target + d * (aimed[0] - 3));
                d = cross(p.normal, random.inside()).normalized();
                target = p.position;
            }
            Ray ray;
            ray.direction = Vec3(d);
            ray.origin = Vec3(target - Vec3d(ray.direction) * distance);
            const auto exact = exact_roots(ray, {&s, nullptr});
            if (!exact) continue;
            std::vector<double> expected;
            for (const ExactRoot& root : *exact)
                expected.insert(expected.end(), size_t(root.multiplicity), root.t);
            const Vec3d from(ray.origin), along(ray.direction);
            const std::vector<double> found = roots(s, from, along);
            ASSERT_EQ(found.size(), expected.size()) << int(s.kind);
            for (size_t k = 0; k < found.size(); ++k) {
                // A surface moved by a rounding moves roots by it over the sine of their angle.
                const Vec3d normal = shape_point(s, from + along * expected[k]).normal;
                EXPECT_NEAR(found[k], expected[k], 4e-16 * distance / std::abs(dot(normal, along)));
            }
        }
    }
}

/// Rays that pass within 1e-8 of the heart's cusps, at which its sides are as close to each other.
TEST(Shapes, AHeartHasTheRootsOfExactArithmeticCloseToItsCusps) {
    const Shape s = make_shape(ShapeKind::heart);
    const struct {
        Vec3 origin, direction;
        size_t roots;
    } known[] = {
        {{0x1.764fdp+0f, -0x1.82ed58p+1f, -0x1.7d8b64p+1f},
         {-0x1.764fc8p+0f, 0x1.02ed6p+1f, 0x1.7d8b5cp+1f},
         2},
        {{0x1.1bfe2p+1f, -0x1.d19c6ap+0f, 0x1.411ad2p+1f},
         {-0x1.17d73cp+2f, 0x1.9d17e4p+0f, -0x1.3c6908p+2f},
         0},
        {{0x1.2cdca2p+1f, 0x1.462ed4p-1f, -0x1.8f5a2cp-1f},
         {-0x1.f3e6e4p+1f, 0x1.34bf6cp-1f, 0x1.4bc66ep+0f},
         2},
        {{2, -0x1.fffffap-1f, 0x1p-40f}, {-1, 0, 0}, 2},  // within the point below
        {{2, 0x1.000008p+0f, 0x1p-40f}, {-1, 0, 0}, 4},   // through the dimple
    };
    for (const auto& [origin, direction, count] : known) {
        const auto exact = exact_roots({origin, 0, direction}, {&s, nullptr});
        ASSERT_TRUE(exact);
        EXPECT_EQ(exact->size(), count);
        const std::vector<double> found = roots(s, Vec3d(origin), Vec3d(direction));
        ASSERT_EQ(found.size(), count);
        for (size_t i = 0; i < count; ++i) EXPECT_NEAR(found[i], (*exact)[i].t, 1e-9);
    }
}

TEST(Roots, AllRootsOfAPolynomialAreFoundInOrder) {
    // (x + 0.9)(x + 0.3)(x − 0.2)(x − 0.2001)(x − 0.8)
    Polynomial<5> p{1};
    Polynomial<5> next{};
    for (const double root : {-0.9, -0.3, 0.2, 0.2001, 0.8}) {
        next = {};
        for (size_t i = 0; i < 5; ++i) next[i + 1] += p[i];
        for (size_t i = 0; i < 6; ++i) next[i] -= root * p[i];
        p = next;
    }
    double found[5];
    ASSERT_EQ(sign_changes<5>(p, -1, 1, found), 5);
    EXPECT_NEAR(found[0], -0.9, 1e-14);
    EXPECT_NEAR(found[2], 0.2, 1e-11);
    EXPECT_NEAR(found[3], 0.2001, 1e-11);
    EXPECT_EQ(sign_changes<5>(p, -0.5, 0.5, found), 3);
}

}  // namespace
}  // namespace sightline
