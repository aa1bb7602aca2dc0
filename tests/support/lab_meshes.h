#pragma once
// Scenes that several tests of the intersection lab share.
#include "scene/scene.h"

#include <random>

namespace sightline {

/// A scene of one baked group.
inline Scene scene_of(std::vector<Mesh> meshes, std::vector<Shape> shapes = {}) {
    Scene scene;
    scene.meshes = std::move(meshes);
    scene.shapes = std::move(shapes);
    scene.groups.resize(1);
    for (uint32_t i = 0; i < scene.meshes.size(); ++i) scene.groups[0].meshes.push_back(i);
    for (uint32_t i = 0; i < scene.shapes.size(); ++i) scene.groups[0].shapes.push_back(i);
    scene.materials.resize(1);
    Instance instance;
    instance.group = 0;
    instance.baked = true;
    scene.instances = {instance};
    return scene;
}

/// A closed sphere of 2·n·n triangles (2·n of them without area) that share their vertices.
inline Mesh globe(uint32_t n, float radius = 1, const Vec3& centre = {0, 0, 0}) {
    Mesh mesh;
    for (uint32_t i = 0; i <= n; ++i)
        for (uint32_t j = 0; j < n; ++j) {
            const float a = pi * static_cast<float>(i) / static_cast<float>(n);
            const float b = 2 * pi * static_cast<float>(j) / static_cast<float>(n);
            const bool pole = i == 0 || i == n;
            const Vec3 p(pole ? 0 : std::sin(a) * std::cos(b),
                         pole ? 1 - 2.0f * (i == n) : std::cos(a),
                         pole ? 0 : std::sin(a) * std::sin(b));
            mesh.positions.push_back(centre + p * radius);
        }
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t j = 0; j < n; ++j) {
            const uint32_t a = i * n + j, b = i * n + (j + 1) % n;
            mesh.triangles.push_back({a, b, a + n});
            mesh.triangles.push_back({b, b + n, a + n});
        }
    return mesh;
}

/// Random numbers for tests: the same on every machine.
struct Dice {
    std::mt19937 random{12345};

    float between(float low, float high) {
        return low + (high - low) * static_cast<float>(random() >> 8) * 0x1p-24f;
    }
    Vec3 vector(float size) {
        const float x = between(-size, size), y = between(-size, size);
        return {x, y, between(-size, size)};
    }
    template <class Container>
    const auto& pick(const Container& from) {
        return from[random() % from.size()];
    }
};

/// Where the rays that decide between methods are aimed.
enum class Aim { anywhere, edge, vertex };

/// A ray from about the middle of the mesh to one of its vertices or to a point of an edge.
inline Ray aimed_ray(const Mesh& mesh, Aim aim, Dice& dice, const Vec3& middle = {0, 0, 0},
                     float spread = 0.3f) {
    const Vec3 origin = middle + dice.vector(spread);
    if (aim == Aim::anywhere) return {origin, 0, dice.vector(1)};
    const auto& triangle = dice.pick(mesh.triangles);
    const Vec3 a = mesh.positions[triangle[0]], b = mesh.positions[triangle[1]];
    const float s = aim == Aim::vertex ? 0 : dice.between(0, 1);
    return {origin, 0, a + (b - a) * s - origin};
}

}  // namespace sightline
