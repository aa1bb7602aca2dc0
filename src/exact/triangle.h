#pragma once
// Exact intersection of a ray and a triangle, behind a filter of bounded doubles.
#include "core/ray.h"

#include <array>
#include <memory>
#include <span>

namespace sightline {

/// A triangle as the scene defines it. Its exact world coordinates are vertex · to_world, without
/// rounding; without a matrix the vertices are world coordinates. All must be finite.
struct InstancedTriangle {
    Vec3 a, b, c;
    const Mat4* to_world = nullptr;  ///< affine; not owned
};

inline bool is_finite(const InstancedTriangle& triangle) {
    return is_finite(triangle.a) && is_finite(triangle.b) && is_finite(triangle.c);
}

/// Whether a ray's segment, tnear < t ≤ tfar, hits a closed triangle. `edge_on`: the line lies in
/// the triangle's plane, or the triangle has no area; there is no single t, and it counts as a
/// miss.
enum class Crossing : uint8_t { miss, hit, edge_on };

/// Exact.
Crossing exact_crossing(const Ray& ray, const InstancedTriangle& triangle);

/// The point at which a ray that hits crosses the plane; each number is correctly rounded.
struct ExactHit {
    double t, u, v;  ///< barycentrics of b and c
    Vec3d normal;    ///< unit, on the side from which a, b, c turn counter-clockwise
};
ExactHit exact_hit(const Ray& ray, const InstancedTriangle& triangle);

/// The t of exact_hit alone, in a tenth of its time.
double exact_t(const Ray& ray, const InstancedTriangle& triangle);

/// The same t, to within about 2^-30 of it, and u and v: in double if that is enough for t, else
/// exactly. u and v are then off by what the rounding of doubles does to them.
struct PlaneHit {
    double t, u, v;
};
PlaneHit plane_hit(const Ray& ray, const InstancedTriangle& triangle);

/// −1, 0, 1: the order along the ray of the planes of two triangles that it hits.
int compare_exactly(const Ray& ray, const InstancedTriangle& first,
                    const InstancedTriangle& second);

/// Bounds of t, for a ray that hits, to within 2^-16 of it.
struct Enclosure {
    double low, high;
};
Enclosure enclose_t(const Ray& ray, const InstancedTriangle& triangle);

/// False if moving one coordinate of the ray's origin or direction or of a vertex by one float ulp
/// changes `exact_crossing`: no method in floats can be expected to be right then.
bool decidable_at_float(const Ray& ray, const InstancedTriangle& triangle);

/// A box around the triangle in world space, tight to within a few ulps.
Box3 exact_bounds(const InstancedTriangle& triangle);

/// A triangle transformed by a chain of matrices, as by glTF nodes. Its vertices are exact
/// products, which floats may not be able to represent.
class NestedTriangle {
  public:
    /// `nodes`: affine, the innermost first.
    NestedTriangle(const std::array<Vec3, 3>& corners, std::span<const Mat4> nodes);

    Crossing crossing(const Ray& ray) const;
    /// Of a ray that hits.
    ExactHit hit(const Ray& ray) const;
    /// The nearest doubles.
    std::array<Vec3d, 3> corners() const;

  private:
    struct Vertices;
    std::shared_ptr<const Vertices> vertices_;
};

/// The precondition of the exact functions: all but tfar is finite, the direction is not zero, and
/// tnear ≤ tfar.
inline bool has_exact_answer(const Ray& ray) {
    const auto finite = [](const Vec3& v) {
        return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    };
    return finite(ray.origin) && finite(ray.direction) && ray.direction != Vec3(0, 0, 0) &&
           std::isfinite(ray.tnear) && ray.tnear <= ray.tfar;
}

/// The rays with one coordinate of the origin or the direction moved by one float ulp: its own, or
/// that of the given size if it is smaller.
std::array<Ray, 12> neighbours_of(const Ray& ray, float origin_size = 0, float direction_size = 0);

}  // namespace sightline
