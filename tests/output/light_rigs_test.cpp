// The built-in lights: what they do not depend on, and where they are seen.
#include "output/render_asset.h"
#include "shade/studio.h"
#include "support/pictures.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

constexpr int size = 32;

/// A white ball beside a mirror, as large as `scale`.
Scene two_balls(float scale) {
    Material mirror;
    mirror.roughness_factor = 0;
    SceneBuilder builder;
    draw(builder, ball({-1.1f * scale, 0, 0}, scale), matte({0.8f, 0.8f, 0.8f}));
    draw(builder, ball({1.1f * scale, 0, 0}, scale), mirror);
    return builder.finish();
}

RenderSettings settings_in(const std::string& light, const Scene& scene) {
    RenderCommand command;
    command.light.env = light;
    command.view.camera = "20/10";
    command.settings.width = 2 * size;
    command.settings.height = size;
    command.settings.samples = 16;
    return complete_settings(command, scene);
}

TEST(LightRigs, LightTheSameAssetOfAnySizeAlike) {
    const Scene one = two_balls(1), large = two_balls(1024), small = two_balls(1.0f / 1024);
    for (const std::string& name : light_names()) {
        const Environment light(light_image(name), 0);
        const Film film = render_scene(one, settings_in(name, one), &light).film;
        for (const Scene* other : {&large, &small}) {
            const Film scaled = render_scene(*other, settings_in(name, *other), &light).film;
            double difference = 0, sum = 0;
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < 2 * size; ++x) {
                    const Vec3 a = beauty_at(film, x, y), b = beauty_at(scaled, x, y);
                    difference += std::fabs(luminance(a - b));
                    sum += luminance(a);
                }
            EXPECT_LT(difference / sum, 1e-3) << name;
        }
    }
}

TEST(LightRigs, AreSeenInMirrorsButNotByTheCamera) {
    const Scene scene = two_balls(1);
    for (const std::string& name : light_names()) {
        const Environment light(light_image(name), 0);
        const Film film = render_scene(scene, settings_in(name, scene), &light).film;
        for (int x = 0; x < 2 * size; ++x)
            EXPECT_LT((beauty_at(film, x, 0) - default_backdrop).length(), 1e-6f) << name;
        float brightest = 0, darkest = 1;
        for (int y = 0; y < size; ++y)
            for (int x = size + 4; x < 2 * size - 4; ++x) {
                brightest = std::max(brightest, luminance(beauty_at(film, x, y)));
                darkest = std::min(darkest, luminance(beauty_at(film, x, y)));
            }
        EXPECT_GT(brightest, 1.5f) << name;
        EXPECT_LT(darkest, 0.3f) << name;
    }
}

TEST(LightRigs, HaveTheSameMeanAndNoneIsTheSameAsAnother) {
    std::vector<Vec3> seen;
    for (const std::string& name : light_names()) {
        const Environment light(light_image(name), 0);
        EXPECT_NEAR(luminance(light.integral()) / (4 * pi), 0.65f, 0.01f) << name;
        const Vec3 above = light.radiance(normalize(Vec3(-0.6f, 0.9f, 0.7f)));
        for (const Vec3& other : seen) EXPECT_NE(other, above) << name;
        seen.push_back(above);
    }
}

/// How bright a white surface is that faces in the direction.
float irradiance_over_pi(const Environment& light, const Vec3& normal) {
    constexpr int rows = 64;
    double sum = 0;
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < 2 * rows; ++x) {
            const double theta = M_PI * (y + 0.5) / rows, phi = M_PI * (x + 0.5) / rows;
            const Vec3 d(float(std::sin(theta) * std::cos(phi)), float(std::cos(theta)),
                         float(std::sin(theta) * std::sin(phi)));
            sum += std::max(0.0, double(dot(d, normal))) * double(luminance(light.radiance(d))) *
                   std::sin(theta);
        }
    return float(sum * M_PI / rows / rows);
}

// The view without options sees the front and the right of a box, from above.
TEST(LightRigs, TheStudioTellsTheSidesOfABoxApartAndBurnsNoWhite) {
    const Environment light(light_image("studio"), 0);
    const float up = irradiance_over_pi(light, {0, 1, 0});
    const float front = irradiance_over_pi(light, {0, 0, 1});
    const float right = irradiance_over_pi(light, {1, 0, 0});
    EXPECT_GT(front, 1.4f * right);
    EXPECT_GT(up, 1.2f * front);
    EXPECT_GT(right, 0.45f);  // brighter than the backdrop, 0.43
    EXPECT_LT(up, 1.3f);
}

TEST(LightRigs, AFilesLampsStandBeforeTheDefaultBackdropToo) {
    SceneBuilder builder;
    draw(builder, ball({0, 0, 0}, 1), matte({0.8f, 0.8f, 0.8f}));
    builder.add_light(point_light({0, 5, 5}, 200));
    const Scene scene = builder.finish();
    const RenderSettings settings = settings_in("none", scene);
    EXPECT_EQ(settings.background, Background::color);
    EXPECT_EQ(settings.background_color, default_backdrop);
}

TEST(LightRigs, AnFStopOpensTheLensOfTheView) {
    const Scene scene = two_balls(1);
    RenderCommand command;
    command.view.camera = "front";
    command.view.f_stop = 2.0f;
    // Before film of 24 mm, 45 degrees are a focal length of 29 mm; its half is the aperture.
    EXPECT_NEAR(complete_settings(command, scene).aperture, 0.012f / std::tan(pi / 8) / 2, 1e-6f);
    command.view.ortho = true;
    EXPECT_EQ(complete_settings(command, scene).aperture, 0);
    command.view.f_stop.reset();
    EXPECT_EQ(complete_settings(command, scene).aperture, 0);
}

}  // namespace
}  // namespace sightline
