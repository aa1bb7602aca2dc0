#include "exact/shape_roots.h"

#include "exact/shape_ray.h"

#include <algorithm>

namespace sightline {
namespace {

using ShapeRay = BasicShapeRay<Dyadic>;

DyadicPolynomial coordinate_of(const ShapeRay& ray, int axis) {
    return std::vector<Dyadic>{ray.origin[axis], ray.direction[axis]};
}

DyadicPolynomial square(const DyadicPolynomial& p) { return p * p; }
DyadicPolynomial constant(const Dyadic& c) { return DyadicPolynomial(c); }

DyadicPolynomial sphere(const ShapeRay& ray, const Shape& shape) {
    const Dyadic r = ray.length(shape.radius);
    return square(coordinate_of(ray, 0)) + square(coordinate_of(ray, 1)) +
           square(coordinate_of(ray, 2)) - constant(r * r);
}

/// (x² + y² + z² + R² − r²)² = 4R²(x² + z²)
DyadicPolynomial torus(const ShapeRay& ray, const Shape& shape) {
    const Dyadic ring = ray.length(shape.radius), tube = ray.length(shape.tube_radius);
    const auto radius2 = square(coordinate_of(ray, 0)) + square(coordinate_of(ray, 2));
    return square(radius2 + square(coordinate_of(ray, 1)) + constant(ring * ring - tube * tube)) -
           constant(Dyadic(4.0) * ring * ring) * radius2;
}

/// 80 (x² + 9z²/4 + y² − s²)³ = s (80 x²y³ + 9 z²y³)
DyadicPolynomial heart(const ShapeRay& ray, const Shape& shape) {
    const Dyadic s = ray.length(shape.scale);
    const auto x2 = square(coordinate_of(ray, 0)), z2 = square(coordinate_of(ray, 2));
    const auto y = coordinate_of(ray, 1), y2 = square(y);
    const auto ball = x2 + constant(Dyadic(2.25)) * z2 + y2 - constant(s * s);
    return constant(Dyadic(80.0)) * ball * square(ball) -
           constant(s) * y * y2 * (constant(Dyadic(80.0)) * x2 + constant(Dyadic(9.0)) * z2);
}

/// h²(x² + z²) = (h(bottom + top)/2 + y(top − bottom))², a cone whose radius changes along y
DyadicPolynomial cone(const ShapeRay& ray, const Shape& shape) {
    const Dyadic h = exact_dyadic(shape.height), top = exact_dyadic(shape.radius_top),
                 bottom = exact_dyadic(shape.radius_bottom);
    const auto radius = constant(h * (bottom + top) * Dyadic(0.5) * ray.scale) +
                        constant(top - bottom) * coordinate_of(ray, 1);
    return constant(h * h) * (square(coordinate_of(ray, 0)) + square(coordinate_of(ray, 2))) -
           square(radius);
}

using Roots = std::vector<RealRoot>;

/// Appends the roots of a surface's equation; none if the surface contains the ray.
void add_roots(const IntegerPolynomial& equation, const Ray& ray, Roots& roots) {
    if (equation.empty()) return;
    const Dyadic near = exact_dyadic(ray.tnear);
    const Dyadic far = std::isinf(ray.tfar) ? Dyadic() : exact_dyadic(ray.tfar);
    const Roots found = real_roots(equation, near, std::isinf(ray.tfar) ? nullptr : &far);
    roots.insert(roots.end(), found.begin(), found.end());
}

/// Appends the crossing with the plane coordinate[axis] = offset if inside(point, factor) accepts
/// it; the point passed is multiplied by the positive factor.
template <class Inside>
void add_plane(const ShapeRay& local, const Ray& ray, int axis, const Dyadic& offset,
               const Inside& inside, Roots& roots) {
    const Dyadic& d = local.direction[axis];
    const Dyadic rise = offset - local.origin[axis];
    if (d.sign() == 0) return;
    const Dyadic sign(d.sign()), denominator = d * sign, numerator = rise * sign;
    const Vec3e point = local.origin * denominator + local.direction * numerator;
    const bool past_near = (numerator - exact_dyadic(ray.tnear) * denominator).sign() > 0;
    const bool before_far =
        std::isinf(ray.tfar) || (numerator - exact_dyadic(ray.tfar) * denominator).sign() <= 0;
    if (past_near && before_far && inside(point, denominator))
        roots.emplace_back(numerator, denominator);
}

bool within(const Dyadic& value, const Dyadic& limit) {
    return (limit - value).sign() >= 0 && (limit + value).sign() >= 0;
}

void add_box(const ShapeRay& local, const Ray& ray, const Shape& shape, Roots& roots) {
    const Dyadic half(0.5);
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            const auto inside = [&](const Vec3e& p, const Dyadic& w) {
                for (int i = 0; i < 3; ++i)
                    if (i != axis && !within(p[i], local.length(shape.size[i]) * half * w))
                        return false;
                return true;
            };
            const Dyadic offset = local.length(side * shape.size[axis]) * half;
            add_plane(local, ray, axis, offset, inside, roots);
        }
}

void add_plane_shape(const ShapeRay& local, const Ray& ray, const Shape& shape, Roots& roots) {
    const auto inside = [&](const Vec3e& p, const Dyadic& w) {
        for (const int i : {0, 2})
            if (shape.size[i] > 0 && !within(p[i], local.length(shape.size[i]) * Dyadic(0.5) * w))
                return false;
        return true;
    };
    add_plane(local, ray, 1, Dyadic(), inside, roots);
}

void add_cylinder(const ShapeRay& local, const Ray& ray, const Shape& shape, Roots& roots) {
    const Dyadic half = local.length(shape.height) * Dyadic(0.5);
    for (const float side : {-1.0f, 1.0f}) {
        const Dyadic radius = local.length(side > 0 ? shape.radius_top : shape.radius_bottom);
        const auto inside = [&](const Vec3e& p, const Dyadic& w) {
            return (radius * radius * w * w - p.x * p.x - p.z * p.z).sign() >= 0;
        };
        add_plane(local, ray, 1, half * exact_dyadic(side), inside, roots);
    }
    Roots wall;
    add_roots(cone(local, shape).integer(), ray, wall);
    const Dyadic& rise = local.direction.y;
    if (rise.sign() == 0) {
        if (within(local.origin.y, half)) roots.insert(roots.end(), wall.begin(), wall.end());
        return;
    }
    RealRoot low(-half - local.origin.y, rise), high(half - local.origin.y, rise);
    for (RealRoot& root : wall)
        if (compare(root, low) * rise.sign() > 0 && compare(root, high) * rise.sign() < 0)
            roots.push_back(root);
}

/// Keeps the roots at which side · (y − limit/h) > 0, or ≥ 0 if `closed`.
void keep_side(const ShapeRay& local, const Dyadic& h, const Dyadic& limit, int side, bool closed,
               Roots& roots) {
    const Dyadic rise = h * local.direction.y, gap = limit - h * local.origin.y;
    std::erase_if(roots, [&](const RealRoot& root) {
        int sign = -gap.sign();
        if (rise.sign() != 0) {
            RealRoot here = root, crossing(gap, rise);
            sign = compare(here, crossing) * rise.sign();
        }
        return !(sign * side > 0 || (closed && sign == 0));
    });
}

/// The convex hull of two spheres: with δ = top − bottom, the cone
/// (h² − δ²)(x² + z²) = (h(bottom + top)/2 + δy)² between the circles where it touches the spheres,
/// and the spheres beyond them.
void add_capsule(const ShapeRay& local, const Ray& ray, const Shape& shape, Roots& roots) {
    const Dyadic h = exact_dyadic(shape.height), top = exact_dyadic(shape.radius_top),
                 bottom = exact_dyadic(shape.radius_bottom), half(0.5);
    const Dyadic delta = top - bottom;
    const bool one_holds_the_other = !within(delta, h) || (h * h - delta * delta).sign() == 0;
    const Dyadic upper = (h * h * half - top * delta) * local.scale,
                 lower = (-(h * h * half) - bottom * delta) * local.scale;
    const auto add_sphere = [&](int side) {
        const Dyadic r = (side > 0 ? top : bottom) * local.scale,
                     centre = local.length(shape.height) * half * Dyadic(side);
        Roots found;
        add_roots(
            (square(coordinate_of(local, 0)) + square(coordinate_of(local, 1) - constant(centre)) +
             square(coordinate_of(local, 2)) - constant(r * r))
                .integer(),
            ray, found);
        if (!one_holds_the_other) keep_side(local, h, side > 0 ? upper : lower, side, true, found);
        roots.insert(roots.end(), found.begin(), found.end());
    };
    if (!one_holds_the_other || delta.sign() >= 0) add_sphere(1);
    if (!one_holds_the_other || delta.sign() < 0) add_sphere(-1);
    if (one_holds_the_other) return;
    const auto radius = constant(h * (bottom + top) * half * local.scale) +
                        constant(delta) * coordinate_of(local, 1);
    Roots wall;
    add_roots((constant(h * h - delta * delta) *
                   (square(coordinate_of(local, 0)) + square(coordinate_of(local, 2))) -
               square(radius))
                  .integer(),
              ray, wall);
    keep_side(local, h, upper, -1, false, wall);
    keep_side(local, h, lower, 1, false, wall);
    roots.insert(roots.end(), wall.begin(), wall.end());
}

void add_all(const ShapeRay& local, const Ray& ray, const Shape& shape, Roots& roots) {
    switch (shape.kind) {
        case ShapeKind::sphere:
            return add_roots(sphere(local, shape).integer(), ray, roots);
        case ShapeKind::torus:
            return add_roots(torus(local, shape).integer(), ray, roots);
        case ShapeKind::heart:
            return add_roots(heart(local, shape).integer(), ray, roots);
        case ShapeKind::box:
            return add_box(local, ray, shape, roots);
        case ShapeKind::plane:
            return add_plane_shape(local, ray, shape, roots);
        case ShapeKind::cylinder:
            return add_cylinder(local, ray, shape, roots);
        case ShapeKind::capsule:
            return add_capsule(local, ray, shape, roots);
    }
}

}  // namespace

std::optional<std::vector<RealRoot>> shape_roots(const Ray& ray, const InstancedShape& shape) {
    ShapeRay local;
    if (!local.enter(ray, shape)) return std::nullopt;
    Roots roots;
    add_all(local, ray, *shape.shape, roots);
    std::sort(roots.begin(), roots.end(), [](const RealRoot& a, const RealRoot& b) {
        RealRoot x = a, y = b;
        return compare(x, y) < 0;
    });
    // A box's edge belongs to two faces.
    const auto same = [](RealRoot a, RealRoot b) { return compare(a, b) == 0; };
    roots.erase(std::unique(roots.begin(), roots.end(), same), roots.end());
    return roots;
}

RealRoot sphere_root(const Ray& ray, const InstancedShape& instanced, const Enclosure& t) {
    ShapeRay local;
    local.enter(ray, instanced);
    return {sphere(local, *instanced.shape).integer(), Dyadic(t.low), Dyadic(t.high), 1};
}

}  // namespace sightline
