#pragma once
// Rays for the tests of intersectors: random numbers, rays aimed at a mesh, calls for a vector of
// rays.
#include "core/ray.h"
#include "intersect/intersector.h"
#include "scene/scene.h"

#include <random>

namespace sightline {

inline constexpr float infinity = std::numeric_limits<float>::infinity();

inline constexpr Coherence coherences[] = {Coherence::coherent, Coherence::incoherent};

inline std::vector<Hit> closest(const Intersector& engine, const std::vector<Ray>& rays,
                                Coherence coherence = Coherence::incoherent,
                                Visible visible = Visible::all) {
    std::vector<Hit> hits(rays.size());
    engine.closest(rays, hits, coherence, visible);
    return hits;
}

inline std::vector<uint8_t> occluded(const Intersector& engine, const std::vector<Ray>& rays,
                                     Coherence coherence = Coherence::incoherent,
                                     Visible visible = Visible::all) {
    std::vector<uint8_t> blocked(rays.size(), 7);
    engine.occluded(rays, blocked, coherence, visible);
    return blocked;
}

/// Random numbers that are the same on every machine.
struct TestRandom {
    std::mt19937 bits{12345};

    float between(float low, float high) {
        return low + (high - low) * static_cast<float>(bits() >> 8) * 0x1p-24f;
    }
    /// Evenly distributed in the cube [−size, size]³.
    Vec3 vector(float size) {
        const float x = between(-size, size), y = between(-size, size);
        return {x, y, between(-size, size)};
    }
    template <class Container>
    const auto& pick(const Container& from) {
        return from[bits() % from.size()];
    }
};

/// The part of a mesh that a ray is aimed at.
enum class Aim { anywhere, edge, vertex };

/// A ray from within `spread` of `middle` to a vertex of the mesh, to a random point of an edge, or
/// in any direction. The direction ends at the target.
inline Ray aimed_ray(const Mesh& mesh, Aim aim, TestRandom& random, const Vec3& middle = {0, 0, 0},
                     float spread = 0.3f) {
    const Vec3 origin = middle + random.vector(spread);
    if (aim == Aim::anywhere) return {origin, 0, random.vector(1)};
    const auto& triangle = random.pick(mesh.triangles);
    const Vec3 a = mesh.positions[triangle[0]], b = mesh.positions[triangle[1]];
    const float s = aim == Aim::vertex ? 0 : random.between(0, 1);
    return {origin, 0, a + (b - a) * s - origin};
}

/// A point evenly distributed in the cube [−1, 1]³.
inline Vec3 random_point(std::mt19937& random) {
    std::uniform_real_distribution<float> unit(-1, 1);
    const float x = unit(random), y = unit(random), z = unit(random);
    return {x, y, z};
}

/// Rays of unit direction from within a sphere of radius 1 around `centre`, aimed at its vertices,
/// at the middles of its edges, or anywhere: each hits it.
inline std::vector<Ray> rays_from_inside(const Mesh& sphere, const Vec3& centre, Aim aim,
                                         size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<Ray> rays(count);
    for (Ray& ray : rays) {
        ray.origin = centre + 0.5f * random_point(random);
        const auto& triangle = sphere.triangles[random() % sphere.triangles.size()];
        const Vec3 &a = sphere.positions[triangle[0]], &b = sphere.positions[triangle[1]];
        const Vec3 target = aim == Aim::vertex ? a
                            : aim == Aim::edge ? (a + b) * 0.5f
                                               : centre + random_point(random) * 4.0f;
        ray.direction = normalize(target - ray.origin);
    }
    return rays;
}

}  // namespace sightline
