#pragma once
// Ray against sphere, each method over any scalar T. All give the roots of the whole line.
#include "intersect/methods/watertight.h"

#include <span>
#include <string_view>
#include <utility>

namespace sightline {

/// Ascending; a tangent is one root or two equal ones.
template <class T>
struct SphereRoots {
    int count = 0;
    T t[2] = {};
};

/// at² + bt + c = 0 by the textbook formula, as in the lecture.
template <class T>
SphereRoots<T> sphere_by_quadratic(const Imath::Vec3<T>& o, const Imath::Vec3<T>& d,
                                   const Imath::Vec3<T>& centre, T radius) {
    const auto s = o - centre;
    const T a = dot(d, d), b = 2 * dot(s, d), c = dot(s, s) - radius * radius;
    const T discriminant = b * b - 4 * a * c;
    if (!(discriminant >= T(0))) return {};
    const T root = std::sqrt(discriminant);
    return {2, {(-b - root) / (2 * a), (-b + root) / (2 * a)}};
}

/// Roots of at² + 2bt + c from its discriminant b² − ac without cancellation between −b and its
/// root (Press et al., Numerical Recipes, section 5.6).
template <class T>
SphereRoots<T> roots_by_stable_q(T a, T b, T c, T discriminant) {
    if (!(discriminant >= T(0))) return {};
    const T q = -(b + std::copysign(std::sqrt(discriminant), b));
    if (q == T(0)) return {2, {T(0), T(0)}};
    T first = q / a, second = c / q;
    if (first > second) std::swap(first, second);
    return {2, {first, second}};
}

/// The same coefficients, solved stably.
template <class T>
SphereRoots<T> sphere_by_stable_q(const Imath::Vec3<T>& o, const Imath::Vec3<T>& d,
                                  const Imath::Vec3<T>& centre, T radius) {
    const auto s = o - centre;
    const T a = dot(d, d), b = dot(s, d), c = dot(s, s) - radius * radius;
    return roots_by_stable_q(a, b, c, b * b - a * c);
}

/// With the discriminant to the last bit by Kahan's difference of products.
template <class T>
SphereRoots<T> sphere_by_kahan(const Imath::Vec3<T>& o, const Imath::Vec3<T>& d,
                               const Imath::Vec3<T>& centre, T radius) {
    const auto s = o - centre;
    const T a = dot(d, d), b = dot(s, d), c = dot(s, s) - radius * radius;
    return roots_by_stable_q(a, b, c, difference_of_products(b, b, a, c));
}

/// Haines, Günther and Akenine-Möller, Precision Improvements for Ray/Sphere Intersection, Ray
/// Tracing Gems 2019, chapter 7: the discriminant from the vector between centre and line.
template <class T>
SphereRoots<T> sphere_by_haines(const Imath::Vec3<T>& o, const Imath::Vec3<T>& d,
                                const Imath::Vec3<T>& centre, T radius) {
    const auto s = o - centre;
    const T a = dot(d, d), b = dot(s, d), c = dot(s, s) - radius * radius;
    const auto perpendicular = s - d * (b / a);
    return roots_by_stable_q(a, b, c, a * (radius * radius - dot(perpendicular, perpendicular)));
}

/// In double, with the origin moved to the point of the line closest to the centre.
template <class T>
SphereRoots<T> sphere_by_shift(const Imath::Vec3<T>& o, const Imath::Vec3<T>& d,
                               const Imath::Vec3<T>& centre, T radius) {
    // NOLINTNEXTLINE(performance-unnecessary-copy-initialization): a copy only if T is double
    const Vec3d direction(d);
    const Vec3d s = Vec3d(o) - Vec3d(centre);
    const double a = dot(direction, direction), closest = -dot(s, direction) / a;
    const Vec3d perpendicular = s + direction * closest;
    const auto r = static_cast<double>(radius);
    // Rounding moves that point a little, so the linear term is kept.
    const double b = dot(perpendicular, direction), c = dot(perpendicular, perpendicular) - r * r;
    const double discriminant = b * b - a * c;
    if (!(discriminant >= 0)) return {};
    const double root = std::sqrt(discriminant);
    return {2,
            {static_cast<T>(closest + (-b - root) / a), static_cast<T>(closest + (-b + root) / a)}};
}

template <class T>
struct SphereMethod {
    std::string_view name;
    SphereRoots<T> (*roots)(const Imath::Vec3<T>& origin, const Imath::Vec3<T>& direction,
                            const Imath::Vec3<T>& centre, T radius);
};

/// All sphere methods by name.
template <class T>
std::span<const SphereMethod<T>> sphere_methods() {
    static constexpr SphereMethod<T> methods[] = {{"quadratic", sphere_by_quadratic<T>},
                                                  {"stable-q", sphere_by_stable_q<T>},
                                                  {"kahan", sphere_by_kahan<T>},
                                                  {"haines", sphere_by_haines<T>},
                                                  {"shifted-double", sphere_by_shift<T>}};
    return methods;
}

}  // namespace sightline
