#pragma once
// Renders of small scenes: materials, lights, settings, the film that comes out.
#include "render/render.h"
#include "scene/camera_fit.h"
#include "support/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

namespace sightline {

/// A Lambertian material: no specular lobe at all.
inline Material matte(const Vec3& color) {
    Material m;
    m.base_color_factor = {color.x, color.y, color.z, 1};
    m.metallic_factor = 0;
    m.specular_factor = 0;
    m.double_sided = true;
    return m;
}

/// Adds a baked mesh with a material of its own.
inline void draw(SceneBuilder& builder, Mesh mesh, const Material& material) {
    builder.add_instance(builder.add_mesh(std::move(mesh), builder.add_material(material)));
}

/// A scene of one baked mesh with one material beside the default one.
inline Scene scene_of(Mesh mesh, const Material& material) {
    SceneBuilder builder;
    draw(builder, std::move(mesh), material);
    return builder.finish();
}

/// A sphere that is shaded smoothly.
inline Mesh ball(const Vec3& centre, float radius) { return sphere_mesh(32, 64, centre, radius); }

/// An environment of one radiance from everywhere.
inline Environment uniform_environment(const Vec3& radiance) {
    Image picture;
    picture.width = 8;
    picture.height = 4;
    picture.channels = 3;
    for (int i = 0; i < 32; ++i)
        picture.floats.insert(picture.floats.end(), {radiance.x, radiance.y, radiance.z});
    return Environment(picture, 0);
}

/// A result with its picture.
struct RenderedScene : RenderResult {
    Film film;
};

/// Renders with Embree and the given needs, or else those of the scene.
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

/// Smooth, clear glass that lets through a share `transmitted` of the light per unit of length.
inline Material absorbing_glass(const Vec3& color, const Vec3& transmitted) {
    Material glass = matte(color);
    glass.specular_factor = 1;
    glass.roughness_factor = 0;
    glass.transmission_factor = 1;
    glass.thickness_factor = 1;
    glass.attenuation_distance = 1;
    glass.attenuation_color = transmitted;
    return glass;
}

/// Glass, rough metal, alpha, an emitter and a point light.
inline Scene rich_scene() {
    Material metal;
    metal.base_color_factor = {1, 0.8f, 0.5f, 1};
    metal.roughness_factor = 0.3f;
    metal.double_sided = true;
    const Material glass = absorbing_glass({0.9f, 1, 0.9f}, {0.5f, 0.9f, 0.6f});
    Material film = matte({0.9f, 0.2f, 0.2f});
    film.base_color_factor.w = 0.4f;
    film.alpha_mode = AlphaMode::blend;
    Material lamp = matte({0, 0, 0});
    lamp.emissive_factor = {5, 4, 3};
    SceneBuilder builder;
    draw(builder, quad_mesh({-4, -1, 4}, {8, 0, 0}, {0, 0, -8}), matte({0.8f, 0.8f, 0.8f}));
    draw(builder, ball({-1.1f, 0, 0}, 1), metal);
    draw(builder, ball({1.1f, 0, 0.5f}, 1), glass);
    draw(builder, quad_mesh({-1, -1, 1.8f}, {2, 0, 0}, {0, 1.5f, 0}), film);
    draw(builder, quad_mesh({-0.5f, 3, -0.5f}, {1, 0, 0}, {0, 0, 1}), lamp);
    builder.add_light(point_light({3, 4, 3}, 30));
    return builder.finish();
}

/// Settings that use all of it: a lens, every layer, the environment behind.
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
