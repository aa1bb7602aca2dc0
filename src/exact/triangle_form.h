#pragma once
// The edge functions of ray and triangle, over exact or bounded arithmetic. Private to src/exact.
#include "exact/bounded.h"
#include "exact/dyadic.h"
#include "exact/triangle.h"

#include <array>

namespace sightline {

/// A float in the arithmetic T.
template <class T>
T from_float(float value) {
    return T(exact_double(value));
}

template <class T>
Imath::Vec3<T> from_floats(const Vec3& v) {
    return {from_float<T>(v.x), from_float<T>(v.y), from_float<T>(v.z)};
}

/// p · m for an affine matrix.
template <class T>
Imath::Vec3<T> moved(const Imath::Vec3<T>& p, const Mat4& m) {
    const auto coordinate = [&](int i) {
        return p.x * from_float<T>(m[0][i]) + p.y * from_float<T>(m[1][i]) +
               p.z * from_float<T>(m[2][i]) + from_float<T>(m[3][i]);
    };
    return {coordinate(0), coordinate(1), coordinate(2)};
}

/// The world coordinates of a triangle's vertices.
template <class T>
std::array<Imath::Vec3<T>, 3> world_vertices(const InstancedTriangle& triangle) {
    std::array<Imath::Vec3<T>, 3> result = {from_floats<T>(triangle.a), from_floats<T>(triangle.b),
                                            from_floats<T>(triangle.c)};
    if (triangle.to_world == nullptr) return result;
    for (Imath::Vec3<T>& p : result) p = moved(p, *triangle.to_world);
    return result;
}

/// Edge functions u, v, w of the vertices b, c, a (their sum is direction·normal), and the
/// numerator of t over that sum: t = distance/(u+v+w).
template <class T>
struct TriangleForm {
    T u, v, w, distance;

    TriangleForm(const Imath::Vec3<T>& origin, const Imath::Vec3<T>& direction,
                 const std::array<Imath::Vec3<T>, 3>& vertices) {
        const auto& [p, q, r] = vertices;
        const Imath::Vec3<T> a = p - origin, b = q - origin, c = r - origin;
        // a × b = a × (b − a): with the edge, the filter's error is proportional to the edge's
        // length.
        u = dot(direction, cross(c, p - r));
        v = dot(direction, cross(a, q - p));
        w = dot(direction, cross(b, r - q));
        distance = dot(a, cross(q - p, r - p));
    }
    TriangleForm(const Ray& ray, const InstancedTriangle& triangle)
        : TriangleForm(from_floats<T>(ray.origin), from_floats<T>(ray.direction),
                       world_vertices<T>(triangle)) {}

    T determinant() const { return u + v + w; }
};

}  // namespace sightline
