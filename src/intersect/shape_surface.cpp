#include "intersect/shape_surface.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr double tau = 2 * 3.14159265358979323846;

/// A point of the surface in shape space; u grows to the right and v downwards as seen from
/// outside, so normal × tangent points against v. Vectors need not be of unit length.
struct Point {
    Vec3d position, normal, tangent;
    double u, v;
};

/// 0…1 around the y axis, 0.5 at +z.
double turn(const Vec3d& p) { return 0.5 + std::atan2(p.x, p.z) / tau; }

/// Along growing turn(); any horizontal direction on the axis.
Vec3d eastwards(const Vec3d& p) {
    return p.x == 0 && p.z == 0 ? Vec3d(1, 0, 0) : Vec3d(p.z, 0, -p.x);
}

double horizontal(const Vec3d& p) { return std::sqrt(p.x * p.x + p.z * p.z); }

/// A direction without its y part, of unit length.
Vec3d outwards(const Vec3d& p) {
    const double length = horizontal(p);
    return length > 0 ? Vec3d(p.x / length, 0, p.z / length) : Vec3d(0, 0, 1);
}

Point on_sphere(const Vec3d& near, double radius, bool parametrised) {
    const double length = near.length();
    const Vec3d n = length > 0 ? near / length : Vec3d(0, 1, 0);
    if (!parametrised) return {n * radius, n, Vec3d(0), 0, 0};
    return {n * radius, n, eastwards(n), turn(n),
            std::acos(std::clamp(n.y, -1.0, 1.0)) / (tau / 2)};
}

Point on_box(const Vec3d& near, const Vec3d& size) {
    const Vec3d half = size * 0.5;
    int axis = 0;
    for (int i = 1; i < 3; ++i)
        if (std::abs(near[i]) - half[i] > std::abs(near[axis]) - half[axis]) axis = i;
    Point point{near, Vec3d(0), Vec3d(0), 0, 0};
    for (int i = 0; i < 3; ++i) point.position[i] = std::clamp(near[i], -half[i], half[i]);
    const double side = near[axis] < 0 ? -1 : 1;
    point.position[axis] = side * half[axis];
    point.normal[axis] = side;
    const Vec3d q = point.position / size;  // −0.5…0.5
    const Vec3d right = axis == 0 ? Vec3d(0, 0, -side) : Vec3d(axis == 1 ? 1 : side, 0, 0);
    const Vec3d down = axis == 1 ? Vec3d(0, 0, side) : Vec3d(0, -1, 0);
    point.tangent = right;
    point.u = 0.5 + dot(q, right);
    point.v = 0.5 + dot(q, down);
    return point;
}

Point on_cap(const Vec3d& near, double y, double radius, double side) {
    const double scale = radius > 0 ? 0.5 / radius : 0;
    return {{near.x, y, near.z},
            {0, side, 0},
            {1, 0, 0},
            0.5 + near.x * scale,
            0.5 + side * near.z * scale};
}

/// The mantle between circles of radius r0 at y0 and r1 at y1; v runs from v1 at y1 to v0 at y0.
Point on_mantle(const Vec3d& near, double y0, double r0, double y1, double r1, double v0,
                double v1) {
    const Vec3d out = outwards(near), start = out * r0 + Vec3d(0, y0, 0);
    const Vec3d along = out * (r1 - r0) + Vec3d(0, y1 - y0, 0);
    const double share = std::clamp(dot(near - start, along) / dot(along, along), 0.0, 1.0);
    return {start + along * share, out * (y1 - y0) + Vec3d(0, r0 - r1, 0), eastwards(out),
            turn(out), v0 + (v1 - v0) * share};
}

Point on_cylinder(const Vec3d& near, const Shape& s) {
    const double half = 0.5 * double(s.height);
    const double top = double(s.radius_top), bottom = double(s.radius_bottom);
    const double slope = (bottom - top) / (2 * half);
    const double radius = bottom - slope * (near.y + half);
    const double outside = (horizontal(near) - radius) / std::sqrt(1 + slope * slope);
    if (near.y - half >= outside && top > 0) return on_cap(near, half, top, 1);
    if (-half - near.y >= outside && bottom > 0) return on_cap(near, -half, bottom, -1);
    return on_mantle(near, -half, bottom, half, top, 1, 0);
}

/// v is the length of the profile from the top pole.
Point on_capsule(const Vec3d& near, const Shape& s) {
    const double half = 0.5 * double(s.height);
    const double top = double(s.radius_top), bottom = double(s.radius_bottom);
    const double sine = std::clamp((bottom - top) / (2 * half), -1.0, 1.0);
    const double cosine = std::sqrt((1 - sine) * (1 + sine)), tilt = std::asin(sine);
    const double upper = top * (tau / 4 - tilt), side = 2 * half * cosine;
    const double lower = bottom * (tau / 4 + tilt), total = upper + side + lower;
    // Along the mantle's profile, from the bottom sphere's centre (0) to the top's (side).
    const double along = (near.y + half) * cosine - horizontal(near) * sine;
    if (along > 0 && along < side)
        return on_mantle(near, -half + bottom * sine, bottom * cosine, half + top * sine,
                         top * cosine, (upper + side) / total, upper / total);
    const bool is_top = along > 0;
    const Vec3d centre(0, is_top ? half : -half, 0);
    Point point = on_sphere(near - centre, is_top ? top : bottom, true);
    point.position += centre;
    const double angle = point.v * tau / 2;
    point.v = is_top ? top * angle / total : 1 - bottom * (tau / 2 - angle) / total;
    return point;
}

Point on_plane(const Vec3d& near, const Vec3d& size) {
    const double u = size.x > 0 ? 0.5 + near.x / size.x : near.x;
    const double v = size.z > 0 ? 0.5 + near.z / size.z : near.z;
    return {{near.x, 0, near.z}, {0, 1, 0}, {1, 0, 0}, u, v};
}

Point on_torus(const Vec3d& near, double ring, double tube) {
    const Vec3d out = outwards(near), centre = out * ring;
    const Vec3d from_centre = near - centre;
    const double length = from_centre.length();
    const Vec3d n = length > 0 ? from_centre / length : out;
    return {centre + n * tube, n, eastwards(out), turn(out),
            0.5 - std::atan2(n.y, dot(n, out)) / tau};
}

/// The heart is star-shaped about its centre: the point is moved along its radius, along which
/// Newton's iteration converges everywhere (the slope there is at least 5/3).
Point on_heart(const Vec3d& near, double scale) {
    const double length = near.length();
    const Vec3d d = length > 0 ? near / length : Vec3d(0, -1, 0);
    const double ball = d.x * d.x + d.y * d.y + 2.25 * d.z * d.z;
    const double root = std::cbrt(d.x * d.x + 0.1125 * d.z * d.z);
    double s = std::max(length / scale, 0.5);
    for (int i = 0; i < 6; ++i) {
        const double third = std::cbrt(s * s);
        s -= (ball * s * s - 1 - d.y * root * s * third) /
             (2 * ball * s - 5.0 / 3.0 * d.y * root * third);
    }
    const Vec3d p = d * s;
    const double width = std::cbrt(p.x * p.x + 0.1125 * p.z * p.z);
    // On the axis the surface has a cusp; its mean direction replaces the normal there.
    Vec3d normal(0, p.y < 0 ? -1 : 1, 0);
    if (width > 0) {
        const double pull = p.y / (3 * width * width);
        normal = Vec3d(2 * p.x * (1 - pull), 2 * p.y - width, p.z * (4.5 - 0.225 * pull));
    }
    const Vec3d n = normalize(normal), east = normalize(eastwards(p));
    const double facing = dot(d, n);
    const Vec3d tangent = std::abs(facing) > 1e-12 ? east - d * (dot(east, n) / facing) : east;
    return {p * scale, n, tangent, turn(d), std::acos(std::clamp(d.y, -1.0, 1.0)) / (tau / 2)};
}

Point on_surface(const Shape& s, const Vec3d& near, bool parametrised) {
    switch (s.kind) {
        case ShapeKind::sphere:
            return on_sphere(near, double(s.radius), parametrised);
        case ShapeKind::box:
            return on_box(near, Vec3d(s.size));
        case ShapeKind::capsule:
            return on_capsule(near, s);
        case ShapeKind::cylinder:
            return on_cylinder(near, s);
        case ShapeKind::plane:
            return on_plane(near, Vec3d(s.size));
        case ShapeKind::torus:
            return on_torus(near, double(s.radius), double(s.tube_radius));
        case ShapeKind::heart:
            return on_heart(near, double(s.scale));
    }
    return {};
}

}  // namespace

ShapePoint shape_point(const Shape& shape, const Vec3d& near_surface, bool parametrised) {
    const Point p = on_surface(shape, transform_point(near_surface, shape.to_shape), parametrised);
    ShapePoint point{transform_point(p.position, shape.to_object),
                     normalize(transform_normal(p.normal, shape.to_shape)),
                     Vec2(float(p.u), float(p.v)), Vec3d(0)};
    if (parametrised) point.tangent = normalize(transform_vector(p.tangent, shape.to_object));
    return point;
}

}  // namespace sightline
