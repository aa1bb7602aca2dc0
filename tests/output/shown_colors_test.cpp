// Background colours and unlit surfaces keep their code values through the tone map.
#include "core/color.h"
#include "core/srgb.h"
#include "output/display.h"
#include "render/aov.h"
#include "support/pictures.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

std::array<int, 3> pixel_of(const Image& image, int x, int y) {
    const size_t at = static_cast<size_t>((y * image.width + x) * image.channels);
    return {image.bytes[at], image.bytes[at + 1], image.bytes[at + 2]};
}

/// A quad in z = 0 from x = `left` to far to the right, seen by a camera 5 away.
Scene half_plane(float left, const Material& material) {
    return scene_of(quad_mesh({left, -9, 0}, {20, 0, 0}, {0, 18, 0}), material);
}

RenderSettings shown_settings(const std::string& background, int samples = 64) {
    RenderSettings settings =
        small_settings(look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, pi / 4), samples, 16, 16);
    settings.aovs = {shown_layer};
    settings.background_color = parse_color(background);
    return settings;
}

Material unlit(const std::string& color) {
    Material m;
    const Vec3 c = parse_color(color);
    m.base_color_factor = {c.x, c.y, c.z, 1};
    m.unlit = true;
    m.double_sided = true;
    return m;
}

TEST(ShownColors, KeepTheirCodeValuesInEveryToneMapAndExposure) {
    const Film film = render_scene(half_plane(0, unlit("#C08040")), shown_settings("#FFFFFF")).film;
    for (const ToneMap map : {ToneMap::pbr_neutral, ToneMap::aces, ToneMap::agx})
        for (const float exposure : {0.0f, 2.0f}) {
            const Image image = display_picture(film, map, exposure, false);
            EXPECT_EQ(pixel_of(image, 2, 8), (std::array{255, 255, 255}));
            EXPECT_EQ(pixel_of(image, 13, 8), (std::array{0xC0, 0x80, 0x40}));
        }
}

TEST(ShownColors, AnEdgeIsAntialiasedAgainstWhite) {
    // The quad begins in the middle of column 8, so it covers half of that.
    const float pixel = 2 * 5 * std::tan(pi / 8) / 16;
    const Film film =
        render_scene(half_plane(pixel / 2, unlit("black")), shown_settings("white", 1024)).film;
    const Image image = display_picture(film, ToneMap::pbr_neutral, 0, false);
    EXPECT_EQ(pixel_of(image, 7, 8)[0], 255);
    EXPECT_NEAR(pixel_of(image, 8, 8)[0], 188, 4);  // half the light
    EXPECT_EQ(pixel_of(image, 9, 8)[0], 0);
}

TEST(ShownColors, TheLitPartOfAnEdgeIsToneMappedAsIfItFilledThePixel) {
    // A matte surface under a sun of radiance 4: bright enough to be compressed.
    SceneBuilder builder;
    const float pixel = 2 * 5 * std::tan(pi / 8) / 16;
    draw(builder, quad_mesh({pixel / 2, -9, 0}, {20, 0, 0}, {0, 18, 0}), matte({0.8f, 0.2f, 0.1f}));
    Light sun;
    sun.kind = LightKind::directional;
    sun.intensity = 4 * pi;
    builder.add_light(sun);
    const Film film = render_scene(builder.finish(), shown_settings("white", 1024)).film;
    const Image image = display_picture(film, ToneMap::pbr_neutral, 0, false);
    const std::array<int, 3> inside = pixel_of(image, 12, 8), edge = pixel_of(image, 8, 8);
    for (size_t c = 0; c < 3; ++c) {
        const float lit = decode_srgb(static_cast<float>(inside[c]) / 255);
        EXPECT_NEAR(edge[c], 255 * encode_srgb((1 + lit) / 2), 4) << c;
    }
}

TEST(ShownColors, AnUnlitSurfaceOverNothingKeepsItsColourAndItsAlpha) {
    Material half = unlit("#C08040");
    half.alpha_mode = AlphaMode::blend;
    half.base_color_factor.w = 0.5f;
    RenderSettings settings = shown_settings("black");
    settings.background = Background::transparent;
    const Film film = render_scene(half_plane(0, half), settings).film;
    const Image image = display_picture(film, ToneMap::pbr_neutral, 0, true);
    EXPECT_EQ(pixel_of(image, 13, 8), (std::array{0xC0, 0x80, 0x40}));
    EXPECT_NEAR(image.bytes[static_cast<size_t>((8 * 16 + 13) * 4 + 3)], 128, 1);
}

TEST(ShownColors, ASmoothPaneOfGlassOverNothingIsMostlyTransparent) {
    Material glass;
    glass.metallic_factor = 0;
    glass.roughness_factor = 0;
    glass.transmission_factor = 1;
    glass.double_sided = true;
    const Environment white = uniform_environment({1, 1, 1});
    RenderSettings settings = shown_settings("black");
    settings.background = Background::transparent;
    settings.aovs.clear();
    const Film film = render_scene(half_plane(0, glass), settings, &white).film;
    const auto at = static_cast<size_t>(8 * 16 + 13);
    // At normal incidence 4 % is reflected by each of both sides: that is all that covers.
    EXPECT_GT(film.find("A")->values[at], 0.02f);
    EXPECT_LT(film.find("A")->values[at], 0.12f);
    EXPECT_NEAR(film.find("R")->values[at], film.find("A")->values[at], 0.02f);
}

}  // namespace
}  // namespace sightline
