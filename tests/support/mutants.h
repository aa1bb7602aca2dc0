#pragma once
// A watertight triangle test with a fault on request: what comparison and atlas must catch.
#include "intersect/ray_rules.h"
#include "scene/scene.h"

namespace sightline {

enum class Mutant { healthy, flipped_sign, epsilon, contraction, shifted_t };

/// The nearest hit of a mesh by the test of Woop, Benthin and Wald ("Watertight Ray/Triangle
/// Intersection", 2013) on every triangle, with the mutant's fault.
inline Hit trace_mutant(const Mesh& mesh, const Ray& ray, Mutant mutant) {
    Hit best;
    best.t = ray.tfar;
    if (!is_valid(ray)) return {};
    const Vec3 d = ray.direction;
    int z = std::abs(d.x) > std::abs(d.y) ? 0 : 1;
    if (std::abs(d.z) > std::abs(d[z])) z = 2;
    int x = (z + 1) % 3, y = (z + 2) % 3;
    if (d[z] < 0) std::swap(x, y);
    const float sx = d[x] / d[z], sy = d[y] / d[z], sz = 1 / d[z];
    const auto edge = [&](const Vec3& a, const Vec3& b) {
        if (mutant == Mutant::contraction) return std::fma(a.x, b.y, -(a.y * b.x));
        return static_cast<float>(static_cast<double>(a.x) * static_cast<double>(b.y) -
                                  static_cast<double>(a.y) * static_cast<double>(b.x));
    };
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        Vec3 p[3];
        for (size_t k = 0; k < 3; ++k) {
            const Vec3 v = mesh.positions[mesh.triangles[i][k]] - ray.origin;
            p[k] = {v[x] - sx * v[z], v[y] - sy * v[z], sz * v[z]};
        }
        float u = edge(p[2], p[1]);
        const float v = edge(p[0], p[2]), w = edge(p[1], p[0]);
        if (mutant == Mutant::flipped_sign) u = -u;
        if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) continue;
        const float det = u + v + w;
        if (det == 0 || (mutant == Mutant::epsilon && std::abs(det) < 0.05f)) continue;
        float t = (u * p[0].z + v * p[1].z + w * p[2].z) / det;
        if (mutant == Mutant::shifted_t) t *= 1 + 0x1p-16f;
        if (!(t > ray.tnear && t < best.t)) continue;
        best = {t, v / det, w / det, i, 0, 0};
    }
    return best ? best : Hit{};
}

}  // namespace sightline
