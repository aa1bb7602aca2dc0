#pragma once
// Scenes made in code, from the library's SceneBuilder and mesh makers. The other headers of this
// folder: rays.h fires rays at a scene, shapes.h has analytic shapes, surfaces.h single hits and
// BSDFs, pictures.h renders scenes, gltf.h makes and loads glTF files, test_folder.h gives a test
// its folder, mutants.h is a triangle test with faults, atlas_scores.h runs a family of the atlas.
#include "scene/mesh_makers.h"
#include "scene/scene_builder.h"

namespace sightline {

/// A scene of one baked group, which is instance 0.
inline Scene scene_of(std::vector<Mesh> meshes, std::vector<Shape> shapes = {}) {
    SceneBuilder builder;
    builder.add_instance(builder.add_group(std::move(meshes), std::move(shapes)));
    return builder.finish();
}

/// A scene without geometry.
inline Scene empty_scene() { return SceneBuilder().finish(); }

/// The triangle (0,0) (4,0) (0,4) in the plane z, facing +z.
inline Mesh triangle_mesh(float z) {
    Mesh mesh;
    mesh.positions = {{0, 0, z}, {4, 0, z}, {0, 4, z}};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
}

/// A closed sphere in n rows of 2·n triangles; those with an edge at a pole, 2·n of them, have no
/// area. All share their vertices but the poles, which have n each.
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

}  // namespace sightline
