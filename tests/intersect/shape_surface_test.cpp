#include "intersect/shape_surface.h"
#include "support/shapes.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(ShapeSurface, PointsAreReprojectedOntoTheSurface) {
    RandomRays random;
    for (const Shape& s : one_of_each()) {
        for (int i = 0; i < 300; ++i) {
            const Vec3d d = random.direction(i), o = random.inside() - d * 3;
            for (const double t : roots(s, o, d)) {
                const Vec3d hit = o + d * t;
                const ShapePoint p = shape_point(s, hit + random.inside() * 1e-7);
                EXPECT_NEAR(double(implicit(s, p.position.x, p.position.y, p.position.z)), 0, 2e-15)
                    << int(s.kind);
                EXPECT_LT((p.position - hit).length(), 2e-4);
                EXPECT_NEAR(p.normal.length(), 1, 1e-12);
                EXPECT_NEAR(p.tangent.length(), 1, 1e-12);
                EXPECT_NEAR(dot(p.normal, p.tangent), 0, 1e-6);
                EXPECT_TRUE(s.kind == ShapeKind::plane || (p.uv.x >= 0 && p.uv.x <= 1)) << p.uv.x;
                EXPECT_TRUE(s.kind == ShapeKind::plane || (p.uv.y >= 0 && p.uv.y <= 1)) << p.uv.y;
            }
        }
    }
}

/// Finite differences of the implicit function and of uv, away from edges and seams.
TEST(ShapeSurface, NormalsPointOutwardsAndTangentsAlongGrowingU) {
    RandomRays random;
    for (const Shape& s : one_of_each()) {
        int checked = 0;
        for (int i = 1; i < 1200; ++i) {
            const Vec3d d = random.direction(i), o = random.inside() - d * 3;
            for (const double t : roots(s, o, d)) {
                const ShapePoint p = shape_point(s, o + d * t);
                constexpr double step = 1e-5;
                const auto moved = [&](const Vec3d& v) { return p.position + v * step; };
                const ShapePoint east = shape_point(s, moved(p.tangent));
                const ShapePoint south = shape_point(s, moved(cross(p.tangent, p.normal)));
                if (dot(east.normal, p.normal) < 0.999 || dot(south.normal, p.normal) < 0.999)
                    continue;
                const Vec3d out = moved(p.normal), in = moved(-p.normal);
                EXPECT_GT(double(implicit(s, out.x, out.y, out.z)), 0) << int(s.kind);
                EXPECT_LT(double(implicit(s, in.x, in.y, in.z)), 0) << int(s.kind);
                const float du = east.uv.x - p.uv.x;
                if (std::abs(du) > 0.5f) continue;  // the seam
                EXPECT_GT(du, 0) << int(s.kind);
                const float dv = south.uv.y - p.uv.y;
                EXPECT_TRUE(dv > 0 || dv < -0.5f) << int(s.kind);
                ++checked;
            }
        }
        EXPECT_GT(checked, 20) << int(s.kind);
    }
}

TEST(ShapeSurface, BoundsContainEveryPointTightly) {
    RandomRays random;
    const Mat4d m =
        Mat4d().setAxisAngle(Vec3d(0.6, 0, 0.8), 0.7) * Mat4d().setTranslation(Vec3d(1, 2, 3));
    for (Shape s : one_of_each()) {
        Box3 seen;
        const Box3 plain = shape_bounds(s);
        s.to_object = m;
        s.to_shape = m.inverse();
        const Box3 turned = shape_bounds(s);
        for (int i = 1; i < 3000; ++i) {
            const Vec3d d = random.direction(i), o = random.inside() - d * 3;
            const ShapeRoots r =
                intersect_shape(s, transform_point(o, m), transform_vector(d, m), 0, infinity);
            for (int k = 0; k < r.count; ++k) {
                seen.extendBy(Vec3(o + d * r.t[k]));
                EXPECT_TRUE(turned.intersects(Vec3(transform_point(o + d * r.t[k], m))));
            }
        }
        for (int j = 0; j < 3; ++j) {
            EXPECT_LE(plain.min[j], seen.min[j] + 1e-6f) << int(s.kind);
            EXPECT_GE(plain.max[j], seen.max[j] - 1e-6f) << int(s.kind);
            EXPECT_LT(plain.size()[j], seen.size()[j] + 0.1f) << int(s.kind);
        }
    }
}

}  // namespace
}  // namespace sightline
