#pragma once
// A ray in a shape's space, over exact or bounded arithmetic. Private to src/exact.
#include "exact/shapes.h"
#include "exact/triangle_form.h"

namespace sightline {

inline std::optional<int> sign_of(const Bounded& x) { return x.sign(); }
inline std::optional<int> sign_of(const Dyadic& x) { return x.sign(); }

/// All lengths, including the shape's own, are multiplied by `scale`, which avoids dividing by the
/// determinant of the instance's matrix.
template <class T>
struct BasicShapeRay {
    Imath::Vec3<T> origin, direction;
    T scale{1.0};

    T length(float value) const { return from_float<T>(value) * scale; }

    /// Takes a ray from the world to the shape's space. Returns false if the instance's matrix has
    /// no inverse, or T cannot tell whether it has one.
    bool enter(const Ray& ray, const InstancedShape& shape) {
        origin = from_floats<T>(ray.origin);
        direction = from_floats<T>(ray.direction);
        if (shape.to_world != nullptr && !enter_instance(*shape.to_world)) return false;
        enter_shape(shape.shape->to_shape);
        return true;
    }

  private:
    bool enter_instance(const Mat4& to_world) {
        Imath::Vec3<T> rows[4];
        for (int i = 0; i < 4; ++i)
            rows[i] = from_floats<T>({to_world[i][0], to_world[i][1], to_world[i][2]});
        const Imath::Vec3<T> columns[] = {cross(rows[1], rows[2]), cross(rows[2], rows[0]),
                                          cross(rows[0], rows[1])};
        const T determinant = dot(rows[0], columns[0]);
        const int orientation = sign_of(determinant).value_or(0);
        if (orientation == 0) return false;
        const T sign(static_cast<double>(orientation));
        const auto enter = [&](const Imath::Vec3<T>& v) {
            return Imath::Vec3<T>{dot(v, columns[0]) * sign, dot(v, columns[1]) * sign,
                                  dot(v, columns[2]) * sign};
        };
        origin = enter(origin - rows[3]);
        direction = enter(direction);
        scale = determinant * sign;
        return true;
    }

    void enter_shape(const Mat4d& m) {
        const auto enter = [&](const Imath::Vec3<T>& v, const T& w) {
            const auto coordinate = [&](int i) {
                return v.x * T(m[0][i]) + v.y * T(m[1][i]) + v.z * T(m[2][i]) + w * T(m[3][i]);
            };
            return Imath::Vec3<T>{coordinate(0), coordinate(1), coordinate(2)};
        };
        origin = enter(origin, scale);
        direction = enter(direction, T(0.0));
    }
};

}  // namespace sightline
