#pragma once
// Analytic shapes, their implicit functions and rays through them.
#include "intersect/shapes.h"
#include "support/rays.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace sightline {

inline Shape make_shape(ShapeKind kind, const Mat4d& to_object = Mat4d()) {
    Shape shape;
    shape.kind = kind;
    shape.to_object = to_object;
    shape.to_shape = to_object.inverse();
    return shape;
}

inline Shape torus(float ring, float tube) {
    Shape shape = make_shape(ShapeKind::torus);
    shape.radius = ring;
    shape.tube_radius = tube;
    return shape;
}

inline Shape cylinder(float bottom, float top, float height) {
    Shape shape = make_shape(ShapeKind::cylinder);
    shape.radius_bottom = bottom;
    shape.radius_top = top;
    shape.height = height;
    return shape;
}

inline std::vector<double> roots(const Shape& shape, const Vec3d& origin, const Vec3d& direction,
                                 double tnear = 0, double tfar = infinity) {
    const ShapeRoots r = intersect_shape(shape, origin, direction, tnear, tfar);
    return {r.t, r.t + r.count};
}

/// The implicit function of a shape in shape space, negative inside, in long double.
inline long double implicit(const Shape& s, long double x, long double y, long double z) {
    using std::abs, std::max, std::sqrt;
    const long double r = s.radius, half = s.height / 2, top = s.radius_top;
    const long double bottom = s.radius_bottom, axial = sqrt(x * x + z * z);
    switch (s.kind) {
        case ShapeKind::sphere:
            return x * x + y * y + z * z - r * r;
        case ShapeKind::box:
            return max({abs(x) - s.size.x / 2, abs(y) - s.size.y / 2, abs(z) - s.size.z / 2});
        case ShapeKind::cylinder:
            return max(abs(y) - half, axial - (bottom + (top - bottom) * (y + half) / (2 * half)));
        case ShapeKind::capsule: {  // the distance to the hull: the farthest of all inner spheres
            const long double sine = (bottom - top) / (2 * half);
            const long double shift = axial * sine / sqrt(1 - sine * sine);
            const long double at = std::clamp((y + half - shift) / (2 * half), 0.0L, 1.0L);
            const long double dy = y + half - 2 * half * at;
            return sqrt(axial * axial + dy * dy) - (bottom + (top - bottom) * at);
        }
        case ShapeKind::plane:
            return y;
        case ShapeKind::torus: {
            const long double tube = s.tube_radius;
            return (axial - r) * (axial - r) + y * y - tube * tube;
        }
        case ShapeKind::heart: {
            const long double a = x * x + 9 * z * z / 4 + y * y - 1;
            return a * a * a - (x * x + 9 * z * z / 80) * y * y * y;
        }
    }
    return 0;
}

inline std::vector<Shape> one_of_each() {
    std::vector<Shape> shapes;
    for (int kind = 0; kind <= int(ShapeKind::heart); ++kind)
        shapes.push_back(make_shape(ShapeKind(kind)));
    shapes[size_t(ShapeKind::capsule)].radius_top = 0.1f;
    shapes[size_t(ShapeKind::cylinder)].radius_bottom = 0.4f;
    shapes.push_back(cylinder(0.5f, 0, 1));
    shapes.push_back(torus(0.5f, 0.01f));
    shapes.push_back(torus(0.5f, 0.5f));
    return shapes;
}

/// Rays through the unit ball from a distance; every third one straight along an axis.
struct RandomRays {
    std::mt19937 engine{7};
    std::uniform_real_distribution<double> uniform{-1, 1};

    Vec3d inside() {
        for (;;) {
            const Vec3d p(uniform(engine), uniform(engine), uniform(engine));
            if (p.length2() <= 1) return p;
        }
    }
    Vec3d direction(int i) {
        if (i % 3 == 0) return Vec3d(i % 9 == 0, i % 9 == 3, i % 9 == 6);
        return inside().normalized();
    }
};

}  // namespace sightline
