#include "shade/fresnel.h"
#include "shade/media.h"
#include "support/pictures.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

Material glass(float dispersion, float roughness = 0) {
    Material m;
    m.metallic_factor = 0;
    m.roughness_factor = roughness;
    m.transmission_factor = 1;
    m.thickness_factor = 1;
    m.dispersion = dispersion;
    return m;
}

constexpr float wedge_angle = 0.35f;

/// A solid with a front in the plane z = 0, and a back that is turned by wedge_angle: it is thicker
/// towards +x.
Mesh wedge() {
    const float slope = std::tan(wedge_angle);
    const auto back = [&](float x, float y) { return Vec3(x, y, -1 - slope * x); };
    Mesh mesh;
    mesh.positions = {{-1, -1, 0},  {1, -1, 0},  {1, 1, 0},  {-1, 1, 0},
                      back(-1, -1), back(1, -1), back(1, 1), back(-1, 1)};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {5, 4, 7}, {5, 7, 6}, {1, 5, 6}, {1, 6, 2},
                      {4, 0, 3}, {4, 3, 7}, {3, 2, 6}, {3, 6, 7}, {4, 5, 1}, {4, 1, 0}};
    return mesh;
}

/// Radiance that grows with the column around −z, and is black elsewhere.
constexpr int columns = 256;
Environment ramp(float rotation = 0) {
    Image image;
    image.width = columns;
    image.height = 8;
    image.channels = 3;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < columns; ++x)
            image.floats.insert(image.floats.end(), 3,
                                x > columns / 8 && x < columns / 2 ? static_cast<float>(x) : 0);
    return Environment(image, rotation);
}

/// Radiance of the ramp in the direction −z, turned by `angle` towards +x.
float ramp_at(float angle) {
    const float u = 0.25f + angle / (2 * pi);
    return u * columns - 0.5f;
}

RenderSettings one_pixel(int samples = 1) {
    RenderSettings settings =
        small_settings(look_at({0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 0.1f), samples, 1, 1);
    settings.background = Background::environment;
    return settings;
}

TEST(Dispersion, IndicesFollowTheAbbeNumber) {
    Material m = glass(20 / 55.0f);  // diamond
    m.ior = 2.42f;
    const Vec3 iors = channel_iors(m);
    EXPECT_EQ(iors.y, 2.42f);
    EXPECT_NEAR((2.42f - 1) / (iors.z - iors.x), 55, 1e-2f);
    EXPECT_NEAR(iors.z - iors.y, iors.y - iors.x, 1e-6f);
    EXPECT_EQ(channel_iors(glass(0)), Vec3(1.5f));
    EXPECT_EQ(channel_iors(glass(1000)).x, 1);
    EXPECT_LE(channel_iors(glass(1e38f)).z, 1000);
    m.ior = 0;  // KHR_materials_ior's special value
    EXPECT_EQ(channel_iors(m), Vec3(0));
}

TEST(Dispersion, APrismTurnsEachChannelByItsIndex) {
    const Environment environment = ramp();
    RenderSettings settings = one_pixel();
    settings.depth = 2;  // in and out
    for (const float dispersion : {0.0f, 1.0f, 5.0f}) {
        const Material material = glass(dispersion);
        const RenderedScene r = render_scene(scene_of(wedge(), material), settings, &environment);
        const Vec3 seen = beauty_at(r.film, 0, 0), iors = channel_iors(material);
        for (int c = 0; c < 3; ++c) {
            const float turned = std::asin(iors[c] * std::sin(wedge_angle)) - wedge_angle;
            const float passed = (1 - fresnel_dielectric(1, iors[c])) *
                                 (1 - fresnel_dielectric(std::cos(wedge_angle), 1 / iors[c]));
            // A thousandth of a column is the rounding of the environment's lookup.
            EXPECT_NEAR(seen[c], passed * ramp_at(turned), 2e-3f) << dispersion << c;
        }
    }
}

TEST(Dispersion, NothingIsLostOrGainedInAFurnace) {
    const Environment white = uniform_environment({1, 1, 1});
    RenderSettings settings = one_pixel();
    settings.depth = 40;
    const RenderedScene r = render_scene(scene_of(wedge(), glass(5)), settings, &white);
    const Vec3 seen = beauty_at(r.film, 0, 0);
    // What goes on after forty boundaries, and below the cutoff of 1e-5.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], 1, 1e-3f);
}

TEST(Dispersion, CostsOneReflectionAndThreeRefractions) {
    const Environment white = uniform_environment({1, 1, 1});
    RenderSettings settings = one_pixel();
    settings.depth = 1;
    const auto count = [&](float dispersion, RayKind kind) {
        const Scene scene = scene_of(wedge(), glass(dispersion));
        return render_scene(scene, settings, &white).counters.rays[static_cast<size_t>(kind)];
    };
    EXPECT_GT(count(0, RayKind::refraction), 0u);
    EXPECT_EQ(count(1, RayKind::refraction), 3 * count(0, RayKind::refraction));
    EXPECT_EQ(count(1, RayKind::reflection), count(0, RayKind::reflection));
}

TEST(Dispersion, LightSamplesAndRaysAgreeOnTheReflectionsOfRoughGlass) {
    const Environment environment = ramp(pi);  // behind the camera
    Material material = glass(5, 0.4f);
    material.base_color_factor = {0, 0, 0, 1};  // lets nothing through
    const Scene scene = scene_of(wedge(), material);
    RenderSettings settings = one_pixel(1 << 14);
    settings.depth = 1;
    Needs needs = find_needs(scene, settings, true);
    const Vec3 both = beauty_at(render_scene(scene, settings, &environment, &needs).film, 0, 0);
    needs.environment_light = false;
    settings.seed = 1;
    const Vec3 rays = beauty_at(render_scene(scene, settings, &environment, &needs).film, 0, 0);
    for (int c = 0; c < 3; ++c) {
        EXPECT_GT(rays[c], 1);
        // Three standard errors of the rays.
        EXPECT_NEAR(both[c] / rays[c], 1, 0.01f) << both << rays;
    }
    EXPECT_GT(both.z, both.x);  // the larger the index, the more is reflected
}

}  // namespace
}  // namespace sightline
