#pragma once
// How far rounding the inputs to float moves a hit: the scale on which t, u and v are judged.
#include "exact/triangle.h"

namespace sightline {

/// Σ |a_i b_i|.
inline double absolute_dot(const Vec3d& a, const Vec3d& b) {
    return std::abs(a.x * b.x) + std::abs(a.y * b.y) + std::abs(a.z * b.z);
}

/// By coordinate: how far the ray's point moves against the triangle's, to first order, if each
/// number of the ray, the vertices and an instance's matrix moves by its own size. `hit` is that of
/// the ray and the triangle.
Vec3d movement_by_own_size(const Ray& ray, const InstancedTriangle& triangle, const PlaneHit& hit);

/// Changes of a hit's numbers, all ≥ 0.
struct HitChange {
    double t = 0, u = 0, v = 0;
};

/// The largest change of the hit, to first order, if each number of the ray and of the triangle
/// (vertices, and the matrix of an instance) moves by half a float ulp: the componentwise condition
/// of Skeel ("Scaling for numerical stability in Gaussian elimination", 1979), times 2^-24.
/// `hit` is that of the ray and the triangle. Infinite where the ray lies in the plane. Coordinates
/// count as at least `least_size` large.
HitChange change_by_rounding(const Ray& ray, const InstancedTriangle& triangle, const PlaneHit& hit,
                             double least_size = 0);

}  // namespace sightline
