#pragma once
// Small scenes made in code, for tests whose answers are known.
#include "render/render.h"
#include "scene/camera_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

namespace sightline {

/// A scene of nothing but the default material.
inline Scene empty_scene() {
    Scene scene;
    scene.path = "test";
    scene.materials.emplace_back();
    return scene;
}

/// Adds a material; returns its index.
inline uint32_t add_material(Scene& scene, const Material& material) {
    scene.materials.push_back(material);
    return static_cast<uint32_t>(scene.materials.size() - 1);
}

/// A Lambertian material: no specular lobe at all.
inline Material matte(const Vec3& color) {
    Material m;
    m.base_color_factor = {color.x, color.y, color.z, 1};
    m.metallic_factor = 0;
    m.specular_factor = 0;
    m.double_sided = true;
    return m;
}

/// Places a mesh as it is, in world space.
inline void add_mesh(Scene& scene, Mesh mesh, uint32_t material) {
    mesh.material = material;
    for (const Vec3& p : mesh.positions) scene.bounds.extendBy(p);
    mesh.positions.reserve(mesh.positions.size() + 1);
    const auto index = static_cast<uint32_t>(scene.meshes.size());
    scene.meshes.push_back(std::move(mesh));
    scene.groups.push_back({{index}, {}});
    Instance instance;
    instance.group = static_cast<uint32_t>(scene.groups.size() - 1);
    instance.baked = true;
    scene.instances.push_back(instance);
}

/// A parallelogram with corner `a` and edges `u`, `v`; its front is the side of cross(u, v).
inline Mesh quad(const Vec3& a, const Vec3& u, const Vec3& v) {
    Mesh mesh;
    mesh.positions = {a, a + u, a + u + v, a + v};
    mesh.texcoords = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

/// A sphere of 2·n² triangles with exact vertex normals.
inline Mesh ball(const Vec3& centre, float radius, uint32_t n = 32) {
    Mesh mesh;
    for (uint32_t i = 0; i <= n; ++i) {
        for (uint32_t j = 0; j <= 2 * n; ++j) {
            const float theta = pi * static_cast<float>(i) / static_cast<float>(n);
            const float phi = pi * static_cast<float>(j % (2 * n)) / static_cast<float>(n);
            const Vec3 d(std::sin(theta) * std::cos(phi), std::cos(theta),
                         -std::sin(theta) * std::sin(phi));
            mesh.positions.push_back(centre + d * radius);
            mesh.normals.push_back(d);
        }
    }
    const uint32_t row = 2 * n + 1;
    for (uint32_t i = 0; i < n; ++i) {
        for (uint32_t j = 0; j < 2 * n; ++j) {
            const uint32_t a = i * row + j;
            if (i > 0) mesh.triangles.push_back({a, a + row, a + 1});
            if (i < n - 1) mesh.triangles.push_back({a + 1, a + row, a + row + 1});
        }
    }
    return mesh;
}

/// An environment of one radiance from everywhere.
inline Environment uniform_environment(const Vec3& radiance) {
    Image picture;
    picture.width = 8;
    picture.height = 4;
    picture.channels = 3;
    for (int i = 0; i < 32; ++i)
        picture.floats.insert(picture.floats.end(), {radiance.x, radiance.y, radiance.z});
    return Environment(std::move(picture), 0);
}

/// A result with its picture.
struct RenderedScene : RenderResult {
    Film film;
};

/// Renders with everything chosen by `needs`, or by the caller.
inline RenderedScene render_scene(const Scene& scene, const RenderSettings& settings,
                                  const Environment* environment = nullptr,
                                  const Needs* needs = nullptr, const RenderRun& run = {}) {
    const Needs found = needs ? *needs : find_needs(scene, settings, environment != nullptr);
    const auto intersector = make_embree(scene, found.embree);
    const RenderContext context(scene, settings, found, *intersector, environment);
    RenderedScene result;
    result.film = blank_film(context.layers.layout, window_of(settings));
    const BandSink keep = [&](const Film& band) { copy_pixels(result.film, band, band.window); };
    static_cast<RenderResult&>(result) = render(context, keep, run);
    return result;
}

/// Beauty of a pixel of the film's window.
inline Vec3 beauty_at(const Film& film, int x, int y) {
    const auto at =
        static_cast<size_t>((y - film.window.y0) * film.window.width() + x - film.window.x0);
    return {film.find("R")->values[at], film.find("G")->values[at], film.find("B")->values[at]};
}

inline RenderSettings small_settings(const Camera& camera, int samples = 1, int width = 64,
                                     int height = 48) {
    RenderSettings settings;
    settings.width = width;
    settings.height = height;
    settings.samples = samples;
    settings.camera = camera;
    settings.background = Background::color;
    settings.cutoff = 1e-5f;
    return settings;
}

inline Light point_light(const Vec3& position, float candela) {
    Light light;
    light.kind = LightKind::point;
    light.position = position;
    light.intensity = candela;
    return light;
}

// A picture with glass, mirror, alpha, an emitter, a point light, an environment and a lens.
inline Scene rich_scene() {
    Scene scene = empty_scene();
    const uint32_t white = add_material(scene, matte({0.8f, 0.8f, 0.8f}));
    Material metal;
    metal.base_color_factor = {1, 0.8f, 0.5f, 1};
    metal.roughness_factor = 0.3f;
    metal.double_sided = true;
    Material glass = matte({0.9f, 1, 0.9f});
    glass.specular_factor = 1;
    glass.roughness_factor = 0;
    glass.transmission_factor = 1;
    glass.thickness_factor = 1;
    glass.attenuation_distance = 1;
    glass.attenuation_color = {0.5f, 0.9f, 0.6f};
    Material film = matte({0.9f, 0.2f, 0.2f});
    film.base_color_factor.w = 0.4f;
    film.alpha_mode = AlphaMode::blend;
    Material lamp = matte({0, 0, 0});
    lamp.emissive_factor = {5, 4, 3};
    add_mesh(scene, quad({-4, -1, 4}, {8, 0, 0}, {0, 0, -8}), white);
    add_mesh(scene, ball({-1.1f, 0, 0}, 1), add_material(scene, metal));
    add_mesh(scene, ball({1.1f, 0, 0.5f}, 1), add_material(scene, glass));
    add_mesh(scene, quad({-1, -1, 1.8f}, {2, 0, 0}, {0, 1.5f, 0}), add_material(scene, film));
    add_mesh(scene, quad({-0.5f, 3, -0.5f}, {1, 0, 0}, {0, 0, 1}), add_material(scene, lamp));
    scene.lights.push_back(point_light({3, 4, 3}, 30));
    return scene;
}

inline RenderSettings rich_settings(int samples) {
    RenderSettings settings =
        small_settings(look_at({0, 1.5f, 6}, {0, 0, 0}, {0, 1, 0}, pi / 4), samples);
    settings.aperture = 0.2f;
    settings.background = Background::environment;
    settings.aovs.insert(std::begin(aov_names), std::end(aov_names));
    return settings;
}

inline bool same_bits(const Channel& a, const Channel& b) {
    const auto equal = [](float x, float y) {
        return std::bit_cast<uint32_t>(x) == std::bit_cast<uint32_t>(y);
    };
    return a.name == b.name && a.integers == b.integers &&
           std::equal(a.values.begin(), a.values.end(), b.values.begin(), b.values.end(), equal);
}

inline void expect_same_film(const Film& a, const Film& b) {
    ASSERT_EQ(a.channels.size(), b.channels.size());
    for (size_t i = 0; i < a.channels.size(); ++i)
        EXPECT_TRUE(same_bits(a.channels[i], b.channels[i])) << a.channels[i].name;
}

}  // namespace sightline
