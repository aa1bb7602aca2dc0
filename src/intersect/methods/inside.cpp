#include "intersect/methods/inside.h"

#include <numbers>

namespace sightline {
namespace {

InstancedTriangle make_triangle(const Mesh& mesh, const std::array<uint32_t, 3>& triangle) {
    return {mesh.positions[triangle[0]], mesh.positions[triangle[1]], mesh.positions[triangle[2]]};
}

/// True if the line crosses the triangle without touching its edges.
bool crosses_cleanly(const Ray& ray, const InstancedTriangle& triangle) {
    const ExactHit hit = exact_hit(ray, triangle);
    return hit.u > 0 && hit.v > 0 && hit.u + hit.v < 1;
}

enum class Parity { even, odd, touching };

Parity parity_along(const Mesh& mesh, const Ray& ray) {
    bool odd = false;
    for (const auto& corners : mesh.triangles) {
        const InstancedTriangle triangle = make_triangle(mesh, corners);
        const Crossing crossing = exact_crossing(ray, triangle);
        if (crossing == Crossing::miss) continue;
        if (crossing == Crossing::edge_on || !crosses_cleanly(ray, triangle))
            return Parity::touching;
        odd = !odd;
    }
    return odd ? Parity::odd : Parity::even;
}

/// Van Oosterom and Strackee, The Solid Angle of a Plane Triangle, 1983.
double solid_angle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const double la = a.length(), lb = b.length(), lc = c.length();
    return 2 * std::atan2(dot(a, cross(b, c)),
                          la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

}  // namespace

bool inside_by_parity(const Mesh& mesh, const Vec3& point) {
    // Directions on a spiral around the sphere: one of them misses all edges.
    for (int i = 0; i < 64; ++i) {
        const float angle = 2.3999632f * static_cast<float>(i);
        const float height = 0.015f + 0.03f * static_cast<float>(i) - 0.96f;
        const Vec3 direction(std::cos(angle), height, std::sin(angle));
        const Parity parity = parity_along(mesh, {point, 0, direction});
        if (parity != Parity::touching) return parity == Parity::odd;
    }
    return winding_number(mesh, point) > 0.5;
}

double winding_number(const Mesh& mesh, const Vec3& point) {
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        sum += solid_angle(Vec3d(mesh.positions[a]) - Vec3d(point),
                           Vec3d(mesh.positions[b]) - Vec3d(point),
                           Vec3d(mesh.positions[c]) - Vec3d(point));
    return sum / (4 * std::numbers::pi);
}

}  // namespace sightline
