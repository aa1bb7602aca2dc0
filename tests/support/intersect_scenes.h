#pragma once
// Small scenes and rays that the tests of intersectors share.
#include "core/ray.h"
#include "intersect/intersector.h"
#include "scene/scene.h"

#include <random>

namespace sightline {

/// A scene whose default material is there, and nothing else.
inline Scene empty_scene() {
    Scene scene;
    scene.materials.resize(1);
    return scene;
}

/// Adds a mesh in a group of its own; returns the group.
inline uint32_t add_group(Scene& scene, Mesh mesh) {
    scene.groups.push_back({{static_cast<uint32_t>(scene.meshes.size())}, {}});
    scene.meshes.push_back(std::move(mesh));
    return static_cast<uint32_t>(scene.groups.size() - 1);
}

/// Adds a shape in a group of its own, moved to `centre`; returns the group.
inline uint32_t add_group(Scene& scene, Shape shape, const Vec3& centre) {
    shape.to_object.setTranslation(Vec3d(centre));
    shape.to_shape = shape.to_object.inverse();
    scene.groups.push_back({{}, {static_cast<uint32_t>(scene.shapes.size())}});
    scene.shapes.push_back(shape);
    return static_cast<uint32_t>(scene.groups.size() - 1);
}

/// Places a group; without a matrix it is baked.
inline void place(Scene& scene, uint32_t group, const Mat4* matrix = nullptr) {
    Instance instance;
    instance.group = group;
    instance.baked = matrix == nullptr;
    if (matrix) {
        instance.object_to_world = *matrix;
        instance.world_to_object = matrix->inverse();
        instance.mirrored = matrix->determinant() < 0;
    }
    scene.instances.push_back(instance);
}

inline constexpr float infinity = std::numeric_limits<float>::infinity();

/// The triangle (0,0) (4,0) (0,4) in the plane z.
inline Mesh triangle(float z) {
    Mesh mesh;
    mesh.positions = {{0, 0, z}, {4, 0, z}, {0, 4, z}};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
}

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

inline constexpr Coherence both[] = {Coherence::coherent, Coherence::incoherent};

/// A closed sphere of radius 1 around `centre`: 2·rows·(rows − 1) triangles in rows of latitude.
inline Mesh sphere_mesh(int rows, const Vec3& centre = {0, 0, 0}) {
    Mesh mesh;
    const int columns = rows;
    const auto radians = [](int step, int steps, float full) {
        return full * static_cast<float>(step) / static_cast<float>(steps);
    };
    mesh.positions.push_back(centre + Vec3(0, 1, 0));
    for (int row = 1; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            const float theta = radians(row, rows, pi), phi = radians(column, columns, 2 * pi);
            mesh.positions.push_back(centre + Vec3(std::sin(theta) * std::cos(phi), std::cos(theta),
                                                   std::sin(theta) * std::sin(phi)));
        }
    }
    mesh.positions.push_back(centre + Vec3(0, -1, 0));
    const auto vertex = [&](int row, int column) {
        if (row == 0) return 0u;
        if (row == rows) return static_cast<uint32_t>(mesh.positions.size() - 1);
        return static_cast<uint32_t>(1 + (row - 1) * columns + column % columns);
    };
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            const uint32_t a = vertex(row, column), b = vertex(row, column + 1);
            const uint32_t c = vertex(row + 1, column), d = vertex(row + 1, column + 1);
            if (row > 0) mesh.triangles.push_back({a, b, c});
            if (row < rows - 1) mesh.triangles.push_back({b, d, c});
        }
    }
    return mesh;
}

/// A point evenly distributed in the cube [−1, 1]³.
inline Vec3 random_point(std::mt19937& random) {
    std::uniform_real_distribution<float> unit(-1, 1);
    const float x = unit(random), y = unit(random), z = unit(random);
    return {x, y, z};
}

enum class Aim { anywhere, vertex, edge };

/// Rays of unit direction from within a sphere_mesh, aimed at its vertices, the middles of its
/// edges, or anywhere: each hits the mesh.
inline std::vector<Ray> rays_from_inside(const Mesh& mesh, const Vec3& centre, Aim aim,
                                         size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<Ray> rays(count);
    for (Ray& ray : rays) {
        ray.origin = centre + 0.5f * random_point(random);
        const auto& triangle = mesh.triangles[random() % mesh.triangles.size()];
        const Vec3 &a = mesh.positions[triangle[0]], &b = mesh.positions[triangle[1]];
        const Vec3 target = aim == Aim::vertex ? a
                            : aim == Aim::edge ? (a + b) * 0.5f
                                               : centre + random_point(random) * 4.0f;
        ray.direction = normalize(target - ray.origin);
    }
    return rays;
}

}  // namespace sightline
