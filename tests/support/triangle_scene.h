#pragma once
// The smallest scene there is, for tests of surfaces.
#include "shade/surface.h"

#include <gtest/gtest.h>

namespace sightline {

/// One triangle in the xy plane, facing +z, with one material; placed once, in world space.
inline Scene triangle_scene() {
    Scene scene;
    scene.materials.resize(1);
    scene.materials[0].metallic_factor = 0;
    scene.meshes.resize(1);
    Mesh& mesh = scene.meshes[0];
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    // As if a picture lay on the plane, upright: u to the right, v down.
    mesh.texcoords = {{{0, 1}, {1, 1}, {0, 0}}};
    mesh.triangles = {{0, 1, 2}};
    scene.groups = {{{0}, {}}};
    scene.instances.resize(1);
    scene.instances[0].group = 0;
    scene.instances[0].baked = true;
    return scene;
}

inline void place(Scene& scene, const Mat4& matrix) {
    Instance& instance = scene.instances[0];
    instance.baked = false;
    instance.object_to_world = matrix;
    instance.world_to_object = matrix.inverse();
    instance.mirrored = matrix.determinant() < 0;
}

/// Gives the scene a texture of one texel, sampled nearest.
inline TextureRef add_texel(Scene& scene, std::vector<uint8_t> texel) {
    Image image;
    image.width = image.height = 1;
    image.channels = static_cast<int>(texel.size());
    image.bytes = std::move(texel);
    scene.images.push_back(image);
    Texture texture;
    texture.image = static_cast<uint32_t>(scene.images.size() - 1);
    scene.textures.push_back(texture);
    TextureRef ref;
    ref.texture = static_cast<uint32_t>(scene.textures.size() - 1);
    return ref;
}

inline Hit middle_hit() {
    Hit hit;
    hit.t = 1;
    hit.u = 0.25f;
    hit.v = 0.5f;
    hit.primitive = hit.geometry = hit.instance = 0;
    return hit;
}

inline Ray towards(const Vec3& direction) {
    Ray ray;
    ray.origin = Vec3(0.25f, 0.5f, 0) - direction;
    ray.direction = direction;
    return ray;
}

inline const Ray from_front = towards({0, 0, -1});
inline const Ray from_back = towards({0, 0, 1});

inline Surface surface(const Scene& scene, const Ray& ray = from_front) {
    return Surfaces(scene).at(ray, middle_hit(), 0);
}

inline void expect_near(const Vec3& a, const Vec3& b, float tolerance = 1e-5f) {
    EXPECT_LT((a - b).length(), tolerance) << a << " " << b;
}

}  // namespace sightline
