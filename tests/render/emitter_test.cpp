// Emitters in pictures: what light samples bring must be what rays see.
#include "support/pictures.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

/// 32 x 32 texels: stripes of colour; dots are cut out.
Image stripes_with_dots() {
    Image image;
    image.width = image.height = 32;
    image.channels = 4;
    for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 32; ++x) {
            const bool lit = x / 4 % 2 == 0, covered = (x / 8 + y / 8) % 3 != 0;
            for (const int value : {lit ? 255 : 0, lit ? 120 : 30, 10, covered ? 255 : 0})
                image.bytes.push_back(static_cast<uint8_t>(value));
        }
    }
    return image;
}

/// A rough metal floor below two instances of a textured, cut-out lamp that shines from both sides:
/// one mirrored, one upside down.
Scene lamps_over_metal(AlphaMode mode) {
    Material floor;
    floor.roughness_factor = 0.6f;
    floor.double_sided = true;
    Material lamp = matte({0, 0, 0});
    lamp.emissive_factor = {3, 3, 3};
    lamp.base_color_factor = {0, 0, 0, 0.8f};
    lamp.alpha_mode = mode;
    lamp.alpha_cutoff = 0.4f;
    lamp.emissive_texture.texture = lamp.base_color_texture.texture = 0;
    SceneBuilder builder;
    draw(builder, quad_mesh({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}), floor);
    const uint32_t lamps = builder.add_mesh(quad_mesh({-0.5f, 0, -0.5f}, {1, 0, 0}, {0, 0, 1}),
                                            builder.add_material(lamp));
    Mat4 mirrored, turned;
    mirrored.setScale(Vec3(-1.5f, 1, 1));
    mirrored[3][0] = -1.2f;
    mirrored[3][1] = 1;
    turned.setAxisAngle(Vec3(1, 0, 0), 2.5f);
    turned[3][0] = 1.2f;
    turned[3][1] = 1.2f;
    builder.add_instance(lamps, mirrored);
    builder.add_instance(lamps, turned);
    Scene scene = builder.finish();
    scene.images = {stripes_with_dots()};
    scene.textures.resize(1);
    scene.textures[0].image = 0;
    scene.textures[0].min = Filter::linear;  // rays see no means of what is cut out
    return scene;
}

/// The floor alone, from above and with the lamps out of view.
RenderSettings floor_settings(int samples) {
    RenderSettings settings =
        small_settings(look_at({0, 0.8f, 1.6f}, {0, 0, 0.4f}, {0, 1, 0}, pi / 4), samples, 16, 12);
    settings.depth = 1;
    return settings;
}

TEST(Emitters, LightSamplesAndRaysAgreeOnTexturedCutOutInstances) {
    for (const AlphaMode mode : {AlphaMode::opaque, AlphaMode::mask, AlphaMode::blend}) {
        const Scene scene = lamps_over_metal(mode);
        RenderSettings settings = floor_settings(SIGHTLINE_SANITIZED ? 512 : 4096);
        const Needs needs = find_needs(scene, settings, false);
        ASSERT_TRUE(needs.area_lights);
        Needs rays_alone = needs;
        rays_alone.area_lights = false;
        const RenderedScene both = render_scene(scene, settings, nullptr, &needs);
        settings.seed = 1;  // independent
        const RenderedScene rays = render_scene(scene, settings, nullptr, &rays_alone);
        double sum = 0, difference = 0, squares = 0;
        for (int y = 0; y < 12; ++y) {
            for (int x = 0; x < 16; ++x) {
                const double a = static_cast<double>(luminance(beauty_at(both.film, x, y)));
                const double b = static_cast<double>(luminance(beauty_at(rays.film, x, y)));
                sum += b;
                difference += a - b;
                squares += (a - b) * (a - b);
            }
        }
        const double error = std::sqrt(squares);  // of the sum of the differences
        EXPECT_LT(error, (SIGHTLINE_SANITIZED ? 0.01 * std::sqrt(8) : 0.01) * sum);
        EXPECT_LT(std::fabs(difference), 3 * error) << sum;
    }
}

/// The radiance in the middle of a white floor of 2 × 2 below a small lamp, seen from aside.
float floor_below_a_lamp(const std::vector<Vec3>& normals) {
    Mesh floor = quad_mesh({-1, 0, 1}, {2, 0, 0}, {0, 0, -2});
    floor.normals = normals;
    Material lamp = matte({0, 0, 0});
    lamp.emissive_factor = {50, 50, 50};
    SceneBuilder builder;
    draw(builder, floor, matte({1, 1, 1}));
    draw(builder, quad_mesh({-0.1f, 2, -0.1f}, {0.2f, 0, 0}, {0, 0, 0.2f}), lamp);
    RenderSettings settings =
        small_settings(look_at({0, 1, 1}, {0, 0, 0}, {0, 1, 0}, 1e-4f), 64, 1, 1);
    return beauty_at(render_scene(builder.finish(), settings).film, 0, 0).x;
}

// The normals of the corners lean outwards, by 20 degrees: shadow rays start 0.4 above the middle.
TEST(Emitters, DoNotShadeThemselvesFromWhatIsSmooth) {
    const float out = std::sin(0.35f) / std::sqrt(2.0f), up = std::cos(0.35f);
    const std::vector<Vec3> normals = {
        {-out, up, out}, {out, up, out}, {out, up, -out}, {-out, up, -out}};
    const float flat = floor_below_a_lamp({});
    EXPECT_NEAR(flat, 50 * 0.04f / 4 / pi, 0.01f * flat);
    EXPECT_NEAR(floor_below_a_lamp(normals), flat, 0.01f * flat);
}

}  // namespace
}  // namespace sightline
