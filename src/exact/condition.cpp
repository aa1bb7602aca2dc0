#include "exact/condition.h"

#include "exact/triangle_form.h"

namespace sightline {
namespace {

constexpr double half_ulp = 0x1p-24;  // of 1

/// By coordinate: how far a vertex moves if its numbers and those of its matrix move by their own
/// size.
Vec3d sizes_of(const Vec3& vertex, const Mat4* to_world) {
    Vec3d size;
    for (int i = 0; i < 3; ++i) {
        if (to_world == nullptr) {
            size[i] = std::abs(exact_double(vertex[i]));
            continue;
        }
        size[i] = std::abs(exact_double((*to_world)[3][i]));
        for (int j = 0; j < 3; ++j)
            size[i] += 2 * std::abs(exact_double(vertex[j]) * exact_double((*to_world)[j][i]));
    }
    return size;
}

}  // namespace

Vec3d movement_by_own_size(const Ray& ray, const InstancedTriangle& triangle, const PlaneHit& hit) {
    Vec3d movement(0, 0, 0);
    const Vec3 vertices[] = {triangle.a, triangle.b, triangle.c};
    const double weights[] = {1 - hit.u - hit.v, hit.u, hit.v};
    for (int k = 0; k < 3; ++k)
        movement += sizes_of(vertices[k], triangle.to_world) * std::abs(weights[k]);
    for (int i = 0; i < 3; ++i)
        movement[i] += std::abs(exact_double(ray.origin[i])) +
                       std::abs(hit.t * exact_double(ray.direction[i]));
    return movement;
}

HitChange change_by_rounding(const Ray& ray, const InstancedTriangle& triangle, const PlaneHit& hit,
                             double least_size) {
    const auto [a, b, c] = world_vertices<double>(triangle);
    const Vec3d direction = from_floats<double>(ray.direction), ab = b - a, ac = c - a;
    Vec3d movement = movement_by_own_size(ray, triangle, hit);
    for (int i = 0; i < 3; ++i) movement[i] = std::max(movement[i], least_size);
    // ab δu + ac δv − direction δt = movement, by Cramer's rule.
    const Vec3d normal = cross(ab, ac);
    const double scale = half_ulp / std::abs(dot(normal, direction));
    return {absolute_dot(normal, movement) * scale,
            absolute_dot(cross(ac, direction), movement) * scale,
            absolute_dot(cross(direction, ab), movement) * scale};
}

}  // namespace sightline
