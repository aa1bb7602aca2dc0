// White balls in an environment of 1 everywhere: what absorbs nothing cannot be seen.
#include "support/pictures.h"

#include <cmath>
#include <functional>
#include <vector>

namespace sightline {
namespace {

/// A ring of pixels at nearly equal angle: the mean and its standard error.
struct Ring {
    double mean = 0, error = 0;
};

/// Mean radiance of each of the rings of a ball that fills the picture, by an orthographic camera.
std::array<Ring, 6> rings_of(const Material& material, int depth, int samples) {
    SceneBuilder builder;
    draw(builder, ball({0, 0, 0}, 1), material);
    Camera camera;
    camera.orthographic = true;
    camera.to_world.setTranslation(Vec3(0, 0, 4));
    RenderSettings settings = small_settings(camera, samples, 48, 48);
    settings.depth = depth;
    settings.background = Background::environment;
    const Environment white = uniform_environment(Vec3(1));
    const Film film = render_scene(builder.finish(), settings, &white).film;
    std::array<double, 6> count{}, sum{}, squares{};
    for (int y = 0; y < 48; ++y) {
        for (int x = 0; x < 48; ++x) {
            const double r = std::hypot(x - 23.5, y - 23.5) / 24;
            if (r > 0.97) continue;  // all of the pixel is on the ball
            const auto k = static_cast<size_t>(r * 6);
            const auto value = static_cast<double>(beauty_at(film, x, y).y);
            ++count[k], sum[k] += value, squares[k] += value * value;
        }
    }
    std::array<Ring, 6> rings;
    for (size_t k = 0; k < 6; ++k) {
        const double mean = sum[k] / count[k];
        const double variance = std::max(0.0, squares[k] / count[k] - mean * mean);
        rings[k] = {mean, std::sqrt(variance / count[k])};
    }
    return rings;
}

void expect_between(double least, double most, const Material& material, int depth,
                    const char* name) {
    const std::array<Ring, 6> rings = rings_of(material, depth, 64);
    for (size_t k = 0; k < rings.size(); ++k) {
        EXPECT_LE(rings[k].mean - 3 * rings[k].error, most) << name << ", ring " << k;
        EXPECT_GE(rings[k].mean + 3 * rings[k].error, least) << name << ", ring " << k;
    }
}

Material white(float metallic, float roughness) {
    Material m;
    m.metallic_factor = metallic;
    m.roughness_factor = roughness;
    return m;
}

TEST(Furnace, WhiteMetalAndPlasticCannotBeSeen) {
    for (const float roughness : {0.0f, 0.3f, 1.0f}) {
        expect_between(0.97, 1.001, white(1, roughness), 4, "metal");
        expect_between(0.97, 1.001, white(0, roughness), 4, "plastic");
    }
}

TEST(Furnace, ACoatAndASheenOverWhiteCannotBeSeen) {
    Material coated = white(1, 0.5f);
    coated.clearcoat_factor = 1;
    coated.clearcoat_roughness_factor = 0.1f;
    expect_between(0.97, 1.001, coated, 4, "coat");
    Material velvet = white(0, 1);
    velvet.sheen_color_factor = Vec3(1);
    velvet.sheen_roughness_factor = 0.1f;
    expect_between(0.97, 1.001, velvet, 4, "sheen over white");
    velvet.base_color_factor = {0, 0, 0, 1};
    velvet.specular_factor = 0;
    expect_between(0, 1.001, velvet, 4, "sheen over black");
}

TEST(Furnace, WhiteGlassCannotBeSeen) {
    // Under sanitizers one of them; release builds measure all.
    for (const float roughness :
         SIGHTLINE_SANITIZED ? std::vector{0.3f} : std::vector{0.0f, 0.3f, 0.7f}) {
        Material pane = white(0, roughness);
        pane.transmission_factor = 1;
        expect_between(0.97, 1.001, pane, 16, "pane");
        pane.thickness_factor = 1;
        expect_between(0.97, 1.001, pane, 32, "solid");
    }
}

TEST(Furnace, AClosedLampshadeLetsLightThrough) {
    Material shade = white(0, 1);
    shade.double_sided = true;
    shade.diffuse_transmission_factor = 1;
    // Light that is reflected inside 16 times is missing.
    expect_between(0.9, 1.001, shade, 16, "lampshade");
}

}  // namespace
}  // namespace sightline
