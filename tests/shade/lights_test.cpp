#include "shade/lights.h"

#include "support/scenes.h"

#include <gtest/gtest.h>

#include <random>

namespace sightline {
namespace {

Light light(LightKind kind) {
    Light l;
    l.kind = kind;
    l.color = {1, 0.5f, 0.25f};
    l.intensity = 8;
    l.position = {0, 3, 0};
    l.direction = {0, -1, 0};
    return l;
}

TEST(Lights, PointLightFallsOffWithTheSquareOfTheDistance) {
    const auto s = sample_punctual(light(LightKind::point), {0, 1, 0});
    ASSERT_TRUE(s);
    EXPECT_EQ(s->wi, Vec3(0, 1, 0));
    EXPECT_EQ(s->distance, 2);
    EXPECT_EQ(s->radiance, Vec3(2, 1, 0.5f));
    EXPECT_EQ(s->pdf, 0);
    EXPECT_FALSE(sample_punctual(light(LightKind::point), {0, 3, 0}));
}

TEST(Lights, DirectionalLightIsTheSameEverywhere) {
    const auto s = sample_punctual(light(LightKind::directional), {100, -5, 3});
    ASSERT_TRUE(s);
    EXPECT_EQ(s->wi, Vec3(0, 1, 0));
    EXPECT_EQ(s->radiance, Vec3(8, 4, 2));
    EXPECT_TRUE(std::isinf(s->distance));
}

TEST(Lights, FalloffReachesZeroSmoothlyAtTheRange) {
    Light l = light(LightKind::point);
    l.range = 4;
    // max(min(1 − (d/range)⁴, 1), 0)/d² at d = 2
    EXPECT_NEAR(sample_punctual(l, {0, 1, 0})->radiance.x, 2 * (1 - 1 / 16.0f), 1e-6f);
    EXPECT_FALSE(sample_punctual(l, {0, -1, 0}));
    EXPECT_FALSE(sample_punctual(l, {0, -5, 0}));
}

TEST(Lights, SpotFadesBetweenItsCones) {
    Light l = light(LightKind::spot);
    l.inner_cone_angle = 0.2f;
    l.outer_cone_angle = 0.6f;
    const auto irradiance = [&](float angle) {
        const auto s = sample_punctual(l, Vec3(std::sin(angle), 3 - std::cos(angle), 0));
        return s ? s->radiance.x : 0;
    };
    EXPECT_NEAR(irradiance(0), 8, 1e-5f);
    EXPECT_NEAR(irradiance(0.19f), 8, 1e-4f);
    const float t = (std::cos(0.4f) - std::cos(0.6f)) / (std::cos(0.2f) - std::cos(0.6f));
    EXPECT_NEAR(irradiance(0.4f), 8 * t * t, 1e-4f);
    EXPECT_EQ(irradiance(0.61f), 0);
    EXPECT_EQ(irradiance(3), 0);
}

/// The unit square in the plane z = 0, which emits towards +z.
Scene square() {
    Scene scene = scene_of({quad_mesh({0, 0, 0}, {1, 0, 0}, {0, 1, 0})});
    scene.materials[0].emissive_factor = {2, 2, 2};
    return scene;
}

struct Estimate {
    double solid_angle = 0, light = 0;
    int found = 0;
};

Estimate estimate(const AreaLights& lights, const Vec3& p, int n = 40000) {
    std::mt19937 generator(1);
    std::uniform_real_distribution<float> uniform(0, 1);
    Estimate sum;
    for (int i = 0; i < n; ++i) {
        const Vec2 u(uniform(generator), uniform(generator));
        const auto s = lights.sample(p, u, uniform(generator));
        if (!s) continue;
        ++sum.found;
        sum.solid_angle += 1 / static_cast<double>(s->pdf) / n;
        sum.light += static_cast<double>(s->radiance.x / s->pdf) / n;
    }
    return sum;
}

/// Solid angle of a unit square from `h` above its middle.
double solid_angle_of_square(double h) { return 4 * std::asin(0.25 / (0.25 + h * h)); }

TEST(AreaLights, SamplingGivesTheSolidAngleOfTheTriangles) {
    const Scene scene = square();
    const Surfaces surfaces(scene);
    const AreaLights lights(scene, surfaces);
    EXPECT_EQ(lights.count(), 2u);
    EXPECT_NEAR(lights.power(), 2 * pi, 1e-5f);
    const double truth = solid_angle_of_square(0.7);
    const Estimate e = estimate(lights, {0.5f, 0.5f, 0.7f});
    EXPECT_NEAR(e.solid_angle / truth, 1, 0.01);
    EXPECT_NEAR(e.light / truth, 2, 0.02);
}

TEST(AreaLights, EmitFromTheFrontOnlyUnlessDoubleSided) {
    Scene scene = square();
    EXPECT_EQ(estimate(AreaLights(scene, Surfaces(scene)), {0.5f, 0.5f, -1}, 100).found, 0);
    scene.materials[0].double_sided = true;
    const Surfaces surfaces(scene);
    EXPECT_EQ(estimate(AreaLights(scene, surfaces), {0.5f, 0.5f, -1}, 100).found, 100);
}

TEST(AreaLights, PdfOfAHitIsThatOfTheSample) {
    Scene scene = square();
    Mat4 matrix;
    matrix.setScale(Vec3(2, 3, -1));  // mirrored: the front stays the front
    scene.instances[0] = make_instance(0, matrix);
    const Surfaces surfaces(scene);
    const AreaLights lights(scene, surfaces);
    const Vec3 p(0.4f, 1.5f, -2);
    const auto s = lights.sample(p, {0.2f, 0.3f}, 0.9f);
    ASSERT_TRUE(s);
    Ray ray;
    ray.origin = p;
    ray.direction = s->wi * 2.0f;
    Hit hit;
    hit.t = s->distance / 2;
    hit.primitive = 1;
    hit.geometry = hit.instance = 0;
    EXPECT_NEAR(lights.pdf(ray, hit) / s->pdf, 1, 1e-5f);
    hit.primitive = 7;
    EXPECT_EQ(lights.pdf(ray, hit), 0);
}

TEST(AreaLights, ArePickedByThePowerOfTheirTexture) {
    Scene scene = square();
    Image image;  // the triangle above the diagonal is black, except for the diagonal
    image.width = image.height = 64;
    image.channels = 3;
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) image.bytes.insert(image.bytes.end(), 3, x > y ? 255 : 0);
    }
    scene.images = {image};
    scene.textures.resize(1);
    scene.textures[0].image = 0;
    scene.materials[0].emissive_texture.texture = 0;
    const Surfaces surfaces(scene);
    const AreaLights lights(scene, surfaces);
    const Estimate e = estimate(lights, {0.5f, 0.5f, 0.7f});
    // Half of the square's light: by symmetry each triangle has half of the solid angle.
    EXPECT_NEAR(e.light, solid_angle_of_square(0.7), 0.03);
}

TEST(AreaLights, IgnoreBlackUnlitAndDegenerateTriangles) {
    Scene scene = square();
    scene.meshes[0].positions[3] = {1, 1, 0};
    EXPECT_EQ(AreaLights(scene, Surfaces(scene)).count(), 1u);
    scene.materials[0].unlit = true;
    EXPECT_TRUE(AreaLights(scene, Surfaces(scene)).empty());
    scene.materials[0].unlit = false;
    scene.materials[0].emissive_factor = Vec3(0);
    const Surfaces surfaces(scene);
    const AreaLights none_at_all(scene, surfaces);
    EXPECT_TRUE(none_at_all.empty());
    EXPECT_FALSE(none_at_all.sample(Vec3(0), {0, 0}, 0));
}

}  // namespace
}  // namespace sightline
