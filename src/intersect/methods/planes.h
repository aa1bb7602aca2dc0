#pragma once
// Ray against plane, over any scalar T.
#include "core/math.h"

#include <optional>

namespace sightline {

/// t = ((p − o)·N)/(d·N), as in the lecture; nothing if the ray is parallel to the plane.
template <class T>
std::optional<T> plane_t(const Imath::Vec3<T>& origin, const Imath::Vec3<T>& direction,
                         const Imath::Vec3<T>& point, const Imath::Vec3<T>& normal) {
    const T slope = dot(direction, normal);
    if (slope == T(0)) return std::nullopt;
    return dot(point - origin, normal) / slope;
}

/// The plane coordinate[axis] = offset: one subtraction and one division.
template <class T>
std::optional<T> axis_plane_t(const Imath::Vec3<T>& origin, const Imath::Vec3<T>& direction,
                              int axis, T offset) {
    if (direction[axis] == T(0)) return std::nullopt;
    return (offset - origin[axis]) / direction[axis];
}

}  // namespace sightline
