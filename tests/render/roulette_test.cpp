// Nothing is dropped that could be seen: what small weights bring has the right mean.
#include "support/pictures.h"

namespace sightline {
namespace {

Material polished_black() {
    Material m = matte({0, 0, 0});
    m.specular_factor = 1;
    m.roughness_factor = 0;
    m.ior = 1.33f;
    return m;
}

// The camera sees a lamp of that radiance in two black mirrors, at 45° each: the path's weight is
// 0.0008, below the cutoff.
Scene lamp_in_two_mirrors(float radiance) {
    SceneBuilder builder;
    Material lamp = matte({0, 0, 0});
    lamp.emissive_factor = Vec3(radiance);
    draw(builder, quad_mesh({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}), polished_black());
    draw(builder, quad_mesh({2, 1, 1}, {0, 2, 0}, {0, 0, -2}), polished_black());
    draw(builder, quad_mesh({-1, 3, 2}, {2, 2, 0}, {0, 0, -4}), lamp);
    return builder.finish();
}

struct Estimate {
    double mean, error;
};

Estimate mean_with_cutoff(const Scene& scene, float cutoff, int samples) {
    RenderSettings settings =
        small_settings(look_at({-2, 2, 0}, {0, 0, 0}, {0, 1, 0}, 0.05f), samples, 16, 16);
    settings.cutoff = cutoff;
    const Film film = render_scene(scene, settings).film;
    double sum = 0, sum2 = 0;
    const auto& values = film.find("G")->values;
    const auto n = static_cast<double>(values.size());
    for (const float v : values) {
        sum += static_cast<double>(v);
        sum2 += static_cast<double>(v) * static_cast<double>(v);
    }
    return {sum / n, std::sqrt(std::max(0.0, sum2 / n - sum * sum / (n * n)) / (n - 1))};
}

constexpr float png_cutoff = 0.5f / 255;

TEST(Roulette, AFaintPathToABrightLampIsSeenInEveryPixel) {
    const Scene scene = lamp_in_two_mirrors(10000);
    const double right = mean_with_cutoff(scene, 1e-9f, 4).mean;
    ASSERT_GT(right, 1);
    EXPECT_NEAR(mean_with_cutoff(scene, png_cutoff, 4).mean, right, 1e-4 * right);
}

// 0.0008 · 3 is above the cutoff, but far from white: roulette decides.
TEST(Roulette, KeepsTheMean) {
    const Scene scene = lamp_in_two_mirrors(3);
    const double right = mean_with_cutoff(scene, 1e-9f, 4).mean;
    const Estimate played = mean_with_cutoff(scene, png_cutoff, 64);
    ASSERT_GT(right, 1e-3);
    EXPECT_GT(played.error, 0) << "some are dropped";
    EXPECT_NEAR(played.mean, right, 3 * played.error);
    EXPECT_LT(played.error, 0.02 * right);
}

TEST(Roulette, KeepsTheMeanOfLightBehindLayers) {
    SceneBuilder builder;
    Material film = matte({0, 0, 0});
    film.base_color_factor.w = 0.9f;
    film.alpha_mode = AlphaMode::blend;
    for (int i = 0; i < 3; ++i)
        draw(builder, quad_mesh({-1, 0.1f * static_cast<float>(i), 1}, {2, 0, 0}, {0, 0, -2}),
             film);
    Material lamp = matte({0, 0, 0});
    lamp.emissive_factor = Vec3(5);
    draw(builder, quad_mesh({-3, -1, 3}, {6, 0, 0}, {0, 0, -6}), lamp);
    const Estimate played = mean_with_cutoff(builder.finish(), png_cutoff, 64);
    EXPECT_NEAR(played.mean, 5e-3, 3 * played.error);
    EXPECT_GT(played.error, 0);
}

TEST(Roulette, TracesNothingThatCannotReachTheCutoff) {
    RenderSettings settings = small_settings(look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 1));
    settings.cutoff = 0.01f;
    Scene scene = lamp_in_two_mirrors(2);
    const Roulette lamp(scene, settings, false);
    EXPECT_EQ(lamp.survival(Vec3(0.01f)), 1);
    EXPECT_GT(lamp.survival(Vec3(0.006f)), 0);
    EXPECT_EQ(lamp.survival(Vec3(0.004f)), 0);
    EXPECT_EQ(lamp.survival(Vec3(0)), 0);
    EXPECT_GT(Roulette(scene, settings, true).survival(Vec3(1e-6f)), 0) << "a sun in the sky";
    scene.lights.push_back(point_light({0, 1, 0}, 1));
    EXPECT_GT(Roulette(scene, settings, false).survival(Vec3(1e-6f)), 0);
}

}  // namespace
}  // namespace sightline
