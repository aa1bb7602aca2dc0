#pragma once
// Single hits and their surfaces: of a scene of one triangle, or filled in by hand for the BSDF.
#include "shade/bsdf.h"
#include "shade/surface.h"
#include "support/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>

namespace sightline {

/// One baked triangle in the xy plane, facing +z, with one material.
inline Scene triangle_scene() {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    // As an upright image on the plane: u to the right, v down.
    mesh.texcoords = {{{0, 1}, {1, 1}, {0, 0}}};
    mesh.triangles = {{0, 1, 2}};
    Scene scene = scene_of({std::move(mesh)});
    scene.materials[0].metallic_factor = 0;
    return scene;
}

/// Adds a texture of one texel to the scene.
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

inline Vec3 direction(float theta, float phi) {
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// White metal in the xy plane with the normal +z; wo is `theta` away from the normal.
inline Surface metal(float theta, float roughness) {
    Surface s;
    s.wo = direction(theta, 0.4f);
    s.ng = s.ns = s.coat_normal = {0, 0, 1};
    s.tangent = {1, 0, 0};
    s.metallic = 1;
    s.roughness = roughness;
    return s;
}

inline Surface dielectric(float theta, float roughness) {
    Surface s = metal(theta, roughness);
    s.metallic = 0;
    return s;
}

inline Surface thin_glass(float theta, float roughness) {
    Surface s = dielectric(theta, roughness);
    s.features = feature_transmission;
    s.transmission = 1;
    return s;
}

inline Surface glass(float theta, float roughness, bool entering = true) {
    Surface s = thin_glass(theta, roughness);
    s.features |= feature_volume;
    s.front = entering;
    s.eta = entering ? 1.5f : 1 / 1.5f;
    return s;
}

inline Surface coated(float theta, float roughness, float coat_roughness) {
    Surface s = metal(theta, roughness);
    s.features = feature_clearcoat;
    s.clearcoat = 1;
    s.clearcoat_roughness = coat_roughness;
    s.base_color = {0.8f, 0.3f, 0.1f};
    return s;
}

inline Surface brushed(float theta) {
    Surface s = metal(theta, 0.4f);
    s.features = feature_anisotropy;
    s.anisotropy = 0.7f;
    return s;
}

struct Named {
    const char* name;
    Surface surface;
};

/// Every kind of rough lobe, for several wo.
inline std::vector<Named> rough_surfaces() {
    std::vector<Named> all;
    for (const float theta : {0.1f, 0.8f, 1.3f}) {
        all.push_back({"metal", metal(theta, 0.5f)});
        all.push_back({"rough metal", metal(theta, 1)});
        all.push_back({"dielectric", dielectric(theta, 0.4f)});
        all.push_back({"brushed", brushed(theta)});
        all.push_back({"thin glass", thin_glass(theta, 0.5f)});
        all.push_back({"glass", glass(theta, 0.5f)});
        all.push_back({"glass from inside", glass(theta, 0.5f, false)});
        all.push_back({"coated", coated(theta, 0.6f, 0.3f)});
    }
    return all;
}

/// Integral over the whole sphere, by the midpoint rule in θ and φ.
inline Vec3d over_sphere(const std::function<Vec3(const Vec3&)>& f) {
    constexpr int rows = 240;
    const float step = pi / rows;
    Vec3d sum(0);
    for (int i = 0; i < rows; ++i) {
        const float theta = step * (static_cast<float>(i) + 0.5f);
        for (int j = 0; j < 2 * rows; ++j) {
            const Vec3 d = direction(theta, step * (static_cast<float>(j) + 0.5f));
            sum += Vec3d(f(d) * (std::sin(theta) * step * step));
        }
    }
    return sum;
}

/// Calls `visit(samples, count)` for `n` random points.
template <class Visit>
void sample_many(const Surface& s, int n, const Visit& visit) {
    std::mt19937 generator(7);
    std::uniform_real_distribution<float> uniform(0, 1);
    const auto u = [&] { return std::min(uniform(generator), 0.99999994f); };
    std::array<BsdfSample, 2> samples;
    for (int i = 0; i < n; ++i) {
        const Vec2 u1(u(), u()), u2(u(), u());
        const int count = sample_bsdf(s, u1, u2, u(), samples);
        visit(samples, count);
    }
}

}  // namespace sightline
