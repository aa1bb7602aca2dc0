#pragma once
// The referee on ray and triangle: exact, behind a filter of bounded doubles.
#include "core/ray.h"

#include <array>
#include <memory>
#include <span>

namespace sightline {

/// A triangle as the scene states it. Its exact place in the world is vertex · to_world, without
/// rounding; no matrix means that the vertices are world coordinates. All must be finite.
struct PlacedTriangle {
    Vec3 a, b, c;
    const Mat4* to_world = nullptr;  ///< affine; not owned
};

/// What a ray's segment, tnear < t ≤ tfar, does with a closed triangle. `edge_on`: its line lies
/// in the triangle's plane, or the triangle has no area; no single t exists and nothing is hit.
enum class Crossing : uint8_t { miss, hit, edge_on };

/// The exact answer.
Crossing exact_crossing(const Ray& ray, const PlacedTriangle& triangle);

/// Where a ray that hits crosses the plane: each number is correctly rounded.
struct ExactHit {
    double t, u, v;  ///< barycentrics of b and c
    Vec3d normal;    ///< unit, on the side from which a, b, c turn counter-clockwise
};
ExactHit exact_hit(const Ray& ray, const PlacedTriangle& triangle);

/// The same t, u and v to within about 2^-30: in double, or exactly where double is not enough.
struct PlaneHit {
    double t, u, v;
};
PlaneHit plane_hit(const Ray& ray, const PlacedTriangle& triangle);

/// −1, 0, 1: the order along the ray of the planes of two triangles that it hits.
int compare_exactly(const Ray& ray, const PlacedTriangle& first, const PlacedTriangle& second);

/// Doubles between which t lies where the ray hits.
struct Enclosure {
    double low, high;
};
Enclosure enclose_t(const Ray& ray, const PlacedTriangle& triangle);

/// False where moving one coordinate of the ray's origin or direction or of a vertex by one float
/// ulp changes `exact_crossing`: a float method cannot be asked to know.
bool decidable_at_float(const Ray& ray, const PlacedTriangle& triangle);

/// A box that holds the placed triangle, the tightest but for a few ulps.
Box3 exact_bounds(const PlacedTriangle& triangle);

/// A triangle under a chain of matrices, as under glTF's nodes: its corners stand where the exact
/// product takes them, which no float need hold.
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
    struct Place;
    std::shared_ptr<const Place> place_;
};

/// All that the exact functions ask of a ray: finite but for tfar, with a direction, tnear ≤ tfar.
inline bool has_exact_answer(const Ray& ray) {
    const auto finite = [](const Vec3& v) {
        return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    };
    return finite(ray.origin) && finite(ray.direction) && ray.direction != Vec3(0, 0, 0) &&
           std::isfinite(ray.tnear) && ray.tnear <= ray.tfar;
}

/// The rays with one coordinate of the origin or the direction moved by one float ulp.
std::array<Ray, 12> neighbours_of(const Ray& ray);

}  // namespace sightline
