#include "intersect/shapes.h"

#include "intersect/roots.h"

#include <algorithm>
#include <limits>

namespace sightline {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The ray in shape space. `nearest` is its point closest to the shape's centre, at t = `t0`:
/// coefficients computed there keep their digits however far away the ray starts.
struct Line {
    Vec3d origin, direction, nearest;
    double direction2;  ///< squared length
    double t0;
};

/// The part of a line inside a convex solid; empty unless lo ≤ hi.
struct Interval {
    double lo = infinity, hi = -infinity;
};

constexpr Interval everything{-infinity, infinity};

Interval operator&(const Interval& a, const Interval& b) {
    return {std::max(a.lo, b.lo), std::min(a.hi, b.hi)};
}

bool is_empty(const Interval& i) { return !(i.lo <= i.hi); }

/// The smallest interval that contains both.
Interval hull(const Interval& a, const Interval& b) {
    if (is_empty(a)) return b;
    if (is_empty(b)) return a;
    return {std::min(a.lo, b.lo), std::max(a.hi, b.hi)};
}

Interval slab(double origin, double direction, double lo, double hi) {
    if (direction == 0) return origin >= lo && origin <= hi ? everything : Interval{};
    const double a = (lo - origin) / direction, b = (hi - origin) / direction;
    return {std::min(a, b), std::max(a, b)};
}

Interval box(const Line& line, const Vec3d& lo, const Vec3d& hi) {
    return slab(line.origin.x, line.direction.x, lo.x, hi.x) &
           slab(line.origin.y, line.direction.y, lo.y, hi.y) &
           slab(line.origin.z, line.direction.z, lo.z, hi.z);
}

/// Discriminant from the perpendicular to the centre (Haines, Günther and Akenine-Möller 2019,
/// Ray Tracing Gems, chapter 7): the textbook's rounded b² − 4ac fails far away.
Interval sphere(const Line& line, double radius) {
    const double discriminant = radius * radius - dot(line.nearest, line.nearest);
    if (!(discriminant >= 0)) return {};
    const double half_chord = std::sqrt(discriminant / line.direction2);
    return {line.t0 - half_chord, line.t0 + half_chord};
}

/// The line with the shape's centre moved to (0, y, 0).
Line recentred(const Line& line, double y) {
    Line moved = line;
    moved.origin.y -= y;
    const double t = -dot(moved.origin, line.direction) / line.direction2;
    moved.nearest = moved.origin + line.direction * t;
    moved.t0 = t;
    return moved;
}

/// The t with a·t² + 2b·t + c ≤ 0 within `range`, for the discriminant b² − ac. For a < 0 they are
/// two half-lines, of which a convex solid within the range contains one.
Interval below_zero(double a, double b, double c, double discriminant, const Interval& range) {
    if (a == 0) {
        if (b == 0) return c <= 0 ? range : Interval{};
        const double root = -c / (2 * b);
        return range & (b > 0 ? Interval{-infinity, root} : Interval{root, infinity});
    }
    if (!(discriminant >= 0)) return a < 0 ? range : Interval{};
    const double q = -(b + std::copysign(std::sqrt(discriminant), b));
    const double r0 = q / a, r1 = q == 0 ? 0 : c / q;
    const double lo = std::min(r0, r1), hi = std::max(r0, r1);
    if (a > 0) return range & Interval{lo, hi};
    const Interval left = range & Interval{-infinity, lo}, right = range & Interval{hi, infinity};
    return left.hi - left.lo > right.hi - right.lo ? left : right;
}

/// The solid between the discs of radius r0 at y0 and r1 at y1 > y0.
Interval frustum(const Line& line, double y0, double r0, double y1, double r1) {
    const Vec3d &o = line.nearest, &d = line.direction;
    const double taper = (r1 - r0) / (y1 - y0);
    const double radius = r0 + taper * (o.y - y0), slope = taper * d.y;
    const double a = d.x * d.x + d.z * d.z - slope * slope;
    const double b = o.x * d.x + o.z * d.z - radius * slope;
    const double c = o.x * o.x + o.z * o.z - radius * radius;
    // b² − ac without its cancelling terms.
    const double x = d.x * radius - o.x * slope, z = d.z * radius - o.z * slope;
    const double area = o.x * d.z - o.z * d.x;
    Interval inside = below_zero(a, b, c, x * x + z * z - area * area, slab(o.y, d.y, y0, y1));
    inside.lo += line.t0;
    inside.hi += line.t0;
    return inside;
}

/// The hull of two spheres: both of them and the cone that touches them along circles.
Interval capsule(const Line& line, const Shape& s) {
    const double half = 0.5 * double(s.height);
    const double top = double(s.radius_top), bottom = double(s.radius_bottom);
    const Interval spheres =
        hull(sphere(recentred(line, half), top), sphere(recentred(line, -half), bottom));
    const double sine = (bottom - top) / (2 * half);  // of the cone's normal above the horizon
    if (std::abs(sine) >= 1) return spheres;          // one sphere contains the other
    const double cosine = std::sqrt((1 - sine) * (1 + sine));
    return hull(spheres, frustum(line, -half + bottom * sine, bottom * cosine, half + top * sine,
                                 top * cosine));
}

/// The ray through a shape of unit size: position and direction at a distance s along it.
struct UnitLine {
    Vec3d origin, direction;
    double t0, t_per_s;

    UnitLine(const Line& line, double size) {
        const double length = std::sqrt(line.direction2);
        origin = line.nearest / size;
        direction = line.direction / length;
        t0 = line.t0;
        t_per_s = size / length;
    }
    Polynomial<1> x() const { return {origin.x, direction.x}; }
    Polynomial<1> y() const { return {origin.y, direction.y}; }
    Polynomial<1> z() const { return {origin.z, direction.z}; }
};

/// Roots of `distance`, whose sign along the line is that of the polynomial. The polynomial only
/// finds the critical points: roots of the well-conditioned function keep more of their digits.
template <int N, class Function>
ShapeRoots polynomial_roots(const UnitLine& line, const Polynomial<N>& p, const Function& distance,
                            const Interval& range) {
    constexpr double touching = 4e-15;  // rounding of `distance` on shapes of unit size
    double critical[N - 1];
    const int count = sign_changes<N - 1>(derivative<N>(p), range.lo, range.hi, critical);
    ShapeRoots roots;
    roots.count = roots_between(distance, critical, count, range.lo, range.hi, touching, roots.t);
    for (int i = 0; i < roots.count; ++i) roots.t[i] = line.t0 + roots.t[i] * line.t_per_s;
    return roots;
}

ShapeRoots torus(const Line& world, const Shape& s) {
    const double size = double(s.radius) + double(s.tube_radius);
    const double ring = double(s.radius) / size, tube = double(s.tube_radius) / size;
    const UnitLine line(world, size);
    const double half2 = 1.01 - dot(line.origin, line.origin);
    if (!(half2 > 0)) return {};
    const auto x2 = multiply<1, 1>(line.x(), line.x()), y2 = multiply<1, 1>(line.y(), line.y()),
               z2 = multiply<1, 1>(line.z(), line.z());
    Polynomial<2> sum;
    for (size_t i = 0; i < 3; ++i) sum[i] = x2[i] + y2[i] + z2[i];
    sum[0] += (ring - tube) * (ring + tube);
    Polynomial<4> p = multiply<2, 2>(sum, sum);
    for (size_t i = 0; i < 3; ++i) p[i] -= 4 * ring * ring * (x2[i] + z2[i]);
    const auto distance = [&](double at) {
        const Vec3d point = line.origin + line.direction * at;
        const double axial = std::sqrt(point.x * point.x + point.z * point.z);
        const double out = axial - ring;
        const double length = std::sqrt(out * out + point.y * point.y);
        const double axial_slope =
            (point.x * line.direction.x + point.z * line.direction.z) / axial;
        return ValueAndSlope{length - tube,
                             (out * axial_slope + point.y * line.direction.y) / length};
    };
    const double half = std::sqrt(half2);
    return polynomial_roots<4>(line, p, distance, {-half, half});
}

/// Taubin's heart with the cube root taken, x² + y² + 9z²/4 − 1 − y·∛(x² + 9z²/80): the same
/// surface, and unlike the sextic its gradient does not vanish on the equator y = 0.
ShapeRoots heart(const Line& world, const Shape& s) {
    const UnitLine line(world, double(s.scale));
    const Line unit{line.origin, line.direction, line.origin, 1, 0};
    constexpr double margin = 1.001;
    const Interval range = box(unit, Vec3d(-heart_x, -1, -heart_z) * margin,
                               Vec3d(heart_x, heart_y, heart_z) * margin);
    if (is_empty(range)) return {};
    const auto x2 = multiply<1, 1>(line.x(), line.x()), y2 = multiply<1, 1>(line.y(), line.y()),
               z2 = multiply<1, 1>(line.z(), line.z());
    Polynomial<2> ball, width;
    for (size_t i = 0; i < 3; ++i) {
        ball[i] = x2[i] + y2[i] + 2.25 * z2[i];
        width[i] = x2[i] + 0.1125 * z2[i];
    }
    ball[0] -= 1;
    Polynomial<6> p = multiply<2, 4>(ball, multiply<2, 2>(ball, ball));
    const auto lobes = multiply<2, 3>(width, multiply<1, 2>(line.y(), y2));
    for (size_t i = 0; i < 6; ++i) p[i] -= lobes[i];
    // Close to the axis the expanded polynomial of the width has lost all digits; squares have not.
    const auto distance = [&](double at) {
        const ValueAndSlope b = evaluate<2>(ball, at);
        const Vec3d &d = line.direction, point = line.origin + d * at;
        const double root = std::cbrt(point.x * point.x + 0.1125 * point.z * point.z);
        const double slope = 2 * (point.x * d.x + 0.1125 * point.z * d.z);
        return ValueAndSlope{b.value - point.y * root,
                             b.slope - d.y * root - point.y * slope / (3 * root * root)};
    };
    return polynomial_roots<6>(line, p, distance, range);
}

ShapeRoots plane(const Line& line, const Shape& s) {
    ShapeRoots roots;
    const double t = -line.origin.y / line.direction.y;
    const Vec3d p = line.origin + line.direction * t;
    const double x = double(s.size.x), z = double(s.size.z);
    if (std::isfinite(t) && (x <= 0 || std::abs(p.x) <= 0.5 * x) &&
        (z <= 0 || std::abs(p.z) <= 0.5 * z))
        roots.t[roots.count++] = t;
    return roots;
}

ShapeRoots ends(const Interval& inside) {
    ShapeRoots roots;
    if (!is_empty(inside)) {
        roots.t[roots.count++] = inside.lo;
        roots.t[roots.count++] = inside.hi;
    }
    return roots;
}

ShapeRoots all_roots(const Shape& s, const Line& line) {
    const double half = 0.5 * double(s.height);
    switch (s.kind) {
        case ShapeKind::sphere:
            return ends(sphere(line, double(s.radius)));
        case ShapeKind::box:
            return ends(box(line, Vec3d(s.size) * -0.5, Vec3d(s.size) * 0.5));
        case ShapeKind::capsule:
            return ends(capsule(line, s));
        case ShapeKind::cylinder:
            return ends(frustum(line, -half, double(s.radius_bottom), half, double(s.radius_top)));
        case ShapeKind::plane:
            return plane(line, s);
        case ShapeKind::torus:
            return torus(line, s);
        case ShapeKind::heart:
            return heart(line, s);
    }
    return {};
}

}  // namespace

ShapeRoots intersect_shape(const Shape& shape, const Vec3d& origin, const Vec3d& direction,
                           double tnear, double tfar) {
    Line line;
    line.origin = transform_point(origin, shape.to_shape);
    line.direction = transform_vector(direction, shape.to_shape);
    line.direction2 = dot(line.direction, line.direction);
    line.t0 = -dot(line.origin, line.direction) / line.direction2;
    if (!std::isfinite(line.t0)) return {};  // also a zero or infinite direction, and NaN
    line.nearest = line.origin + line.direction * line.t0;
    const ShapeRoots all = all_roots(shape, line);
    ShapeRoots within;
    for (int i = 0; i < all.count; ++i)
        if (all.t[i] >= tnear && all.t[i] <= tfar) within.t[within.count++] = all.t[i];
    return within;
}

}  // namespace sightline
