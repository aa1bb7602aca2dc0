#pragma once
// Aliases of Imath's vectors and matrices. Points and directions are row vectors: p' = p * M.
#include <Imath/ImathBox.h>
#include <Imath/ImathMatrix.h>
#include <Imath/ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sightline {

using Vec2 = Imath::V2f;
using Vec3 = Imath::V3f;
using Vec4 = Imath::V4f;
using Vec3d = Imath::V3d;
using Mat3 = Imath::M33f;
using Mat4 = Imath::M44f;
using Mat4d = Imath::M44d;
using Box3 = Imath::Box3f;

/// A missing index, in every index field of the scene and of a hit.
inline constexpr uint32_t none = 0xffffffffu;

inline constexpr float pi = 3.14159265358979323846f;

template <class T>
T dot(const Imath::Vec3<T>& a, const Imath::Vec3<T>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class T>
Imath::Vec3<T> cross(const Imath::Vec3<T>& a, const Imath::Vec3<T>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// `v` scaled to unit length; the zero vector stays zero.
template <class T>
Imath::Vec3<T> normalize(const Imath::Vec3<T>& v) {
    const T length2 = dot(v, v);
    return length2 > 0 ? v * (1 / std::sqrt(length2)) : v;
}

inline float max_component(const Vec3& v) { return std::max(v.x, std::max(v.y, v.z)); }

/// The largest absolute component.
inline float max_abs_component(const Vec3& v) {
    return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

inline bool is_finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Whether all elements are finite as floats.
template <class T>
bool is_finite(const Imath::Matrix44<T>& m) {
    return std::all_of(m.getValue(), m.getValue() + 16,
                       [](T x) { return std::isfinite(static_cast<float>(x)); });
}

inline bool is_black(const Vec3& c) { return !(max_component(c) > 0); }

/// Rec. 709 luminance of a linear colour.
inline float luminance(const Vec3& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

/// A point transformed by an affine matrix.
template <class T>
Imath::Vec3<T> transform_point(const Imath::Vec3<T>& p, const Imath::Matrix44<T>& m) {
    return {p.x * m[0][0] + p.y * m[1][0] + p.z * m[2][0] + m[3][0],
            p.x * m[0][1] + p.y * m[1][1] + p.z * m[2][1] + m[3][1],
            p.x * m[0][2] + p.y * m[1][2] + p.z * m[2][2] + m[3][2]};
}

/// A direction transformed by an affine matrix; not normalised.
template <class T>
Imath::Vec3<T> transform_vector(const Imath::Vec3<T>& v, const Imath::Matrix44<T>& m) {
    return {v.x * m[0][0] + v.y * m[1][0] + v.z * m[2][0],
            v.x * m[0][1] + v.y * m[1][1] + v.z * m[2][1],
            v.x * m[0][2] + v.y * m[1][2] + v.z * m[2][2]};
}

/// A normal transformed by the inverse transpose, given the *inverse* matrix; not normalised.
template <class T>
Imath::Vec3<T> transform_normal(const Imath::Vec3<T>& n, const Imath::Matrix44<T>& inverse) {
    return {n.x * inverse[0][0] + n.y * inverse[0][1] + n.z * inverse[0][2],
            n.x * inverse[1][0] + n.y * inverse[1][1] + n.z * inverse[1][2],
            n.x * inverse[2][0] + n.y * inverse[2][1] + n.z * inverse[2][2]};
}

}  // namespace sightline
