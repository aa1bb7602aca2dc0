#include "scene/shape_support.h"

#include "scene/shape_bounds.h"

#include <cmath>
#include <vector>

namespace sightline {
namespace {

// Zero stays zero.
Vec3d horizontal(const Vec3d& v) { return normalize(Vec3d(v.x, 0, v.z)); }

Vec3d box_corner(const Vec3d& half, const Vec3d& d) {
    return {std::copysign(half.x, d.x), std::copysign(half.y, d.y), std::copysign(half.z, d.z)};
}

Vec3d farther(const Vec3d& a, const Vec3d& b, const Vec3d& d) {
    return dot(a, d) < dot(b, d) ? b : a;
}

// How far the heart of scale 1 reaches from its centre along a unit vector: it is star-shaped.
double heart_radius(const Vec3d& d) {
    double inside = 0, outside = 2;
    for (int i = 0; i < 40; ++i) {
        const double t = (inside + outside) / 2;
        const double x2 = t * d.x * t * d.x, y = t * d.y, z2 = t * d.z * t * d.z;
        const double a = x2 + 9 * z2 / 4 + y * y - 1;
        (a * a * a - x2 * y * y * y - 9 * z2 * y * y * y / 80 < 0 ? inside : outside) = t;
    }
    return outside;
}

std::vector<Vec3d> sample_heart() {
    constexpr int rows = 180, columns = 360;
    std::vector<Vec3d> points;
    for (int i = 0; i <= rows; ++i) {
        const double theta = M_PI * i / rows;
        for (int j = 0; j < columns; ++j) {
            const double phi = 2 * M_PI * j / columns;
            const Vec3d d(std::sin(theta) * std::cos(phi), std::cos(theta),
                          std::sin(theta) * std::sin(phi));
            points.push_back(d * heart_radius(d));
        }
    }
    return points;
}

Vec3d heart_point(const Vec3d& d) {
    static const std::vector<Vec3d> points = sample_heart();
    Vec3d best = points[0];
    for (const Vec3d& p : points) best = farther(best, p, d);
    return best;
}

// Of a capsule: a ball at each end. Of a cylinder: a disc at each end.
Vec3d round_ends_point(const Shape& s, const Vec3d& d) {
    const Vec3d outwards = s.kind == ShapeKind::capsule ? normalize(d) : horizontal(d);
    const Vec3d axis(0, 0.5 * double(s.height), 0);
    return farther(axis + outwards * double(s.radius_top),
                   outwards * double(s.radius_bottom) - axis, d);
}

}  // namespace

Vec3d farthest_point(const Shape& s, const Vec3d& d) {
    switch (s.kind) {
        case ShapeKind::sphere:
            return normalize(d) * double(s.radius);
        case ShapeKind::box:
            return box_corner(Vec3d(s.size) * 0.5, d);
        case ShapeKind::capsule:
        case ShapeKind::cylinder:
            return round_ends_point(s, d);
        case ShapeKind::plane:
            return box_corner({s.size.x > 0 ? 0.5 * double(s.size.x) : 1e6, 0,
                               s.size.z > 0 ? 0.5 * double(s.size.z) : 1e6},
                              d);
        case ShapeKind::torus:
            return horizontal(d) * double(s.radius) + normalize(d) * double(s.tube_radius);
        case ShapeKind::heart:
            return heart_point(d) * double(s.scale);
    }
    return Vec3d(0, 0, 0);
}

}  // namespace sightline
