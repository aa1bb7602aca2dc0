// Copies of an environment: brighter, blurred, changed by height.
#include "shade/environment.h"
#include "support/pictures.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

/// Black but for one bright texel at the horizon.
Image one_bright_texel() {
    Image image;
    image.width = 256;
    image.height = 128;
    image.channels = 3;
    image.floats.assign(static_cast<size_t>(256 * 128 * 3), 0.0f);
    for (size_t c = 0; c < 3; ++c) image.floats[3 * (64 * 256 + 128) + c] = 1000;
    return image;
}

TEST(EnvironmentCopies, ABrightnessIsAFactor) {
    const Image image = one_bright_texel();
    const Environment one(image, 0), three(image, 0, 3);
    const Vec3 d = normalize(Vec3(1, 0.01f, 0.01f));
    EXPECT_GT(one.radiance(d).x, 0);
    EXPECT_NEAR(three.radiance(d).x, 3 * one.radiance(d).x, 1e-3f);
}

TEST(EnvironmentCopies, BlurKeepsTheLightAndSpreadsIt) {
    const Environment sharp(one_bright_texel(), 0);
    for (const float degrees : {4.0f, 20.0f, 60.0f}) {
        const Environment blurred = sharp.blurred(degrees * pi / 180);
        EXPECT_NEAR(blurred.integral().x / sharp.integral().x, 1, 0.06f) << degrees;
        const auto at = [&](float angle) {
            return blurred.radiance({std::cos(angle), std::sin(angle), 0}).x;
        };
        const float radius = degrees * pi / 180;
        EXPECT_GT(at(0), 0);
        EXPECT_NEAR(at(radius) / at(0), std::exp(-2.0f), 0.06f) << degrees;
        EXPECT_LT(at(std::min(2 * radius, 1.5f)), 0.03f * at(0)) << degrees;
    }
}

TEST(EnvironmentCopies, AnEvenEnvironmentStaysEvenWhenBlurred) {
    const Environment blurred = uniform_environment({0.3f, 0.5f, 0.7f}).blurred(0.5f);
    for (const Vec3& d : {Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(1, 0, 0), Vec3(0, 0.6f, -0.8f)})
        EXPECT_NEAR((blurred.radiance(d) - Vec3(0.3f, 0.5f, 0.7f)).length(), 0, 1e-5f);
}

TEST(EnvironmentCopies, TheIntegralIsThatOfTheImage) {
    EXPECT_NEAR(uniform_environment({0.25f, 0.5f, 1}).integral().y, 4 * pi * 0.5f, 0.2f);
    EXPECT_EQ(uniform_environment({0, 0, 0}).integral(), Vec3(0, 0, 0));
    const Environment upper = uniform_environment({1, 1, 1}).changed(
        [](float y, const Vec3& radiance) { return radiance * std::max(y, 0.0f); }, 256);
    EXPECT_NEAR(upper.integral().x, pi, 0.001f);
}

TEST(EnvironmentCopies, KeepTheirRotation) {
    const Environment sharp(one_bright_texel(), 1);
    const Environment large =
        sharp.changed([](float, const Vec3& radiance) { return radiance; }, 512);
    for (int i = 0; i < 64; ++i) {
        const float phi = 0.1f * static_cast<float>(i);
        const Vec3 d(std::cos(phi), 0, std::sin(phi));
        EXPECT_NEAR(large.radiance(d).x, sharp.radiance(d).x, 300) << i;
    }
    EXPECT_NEAR(large.integral().x / sharp.integral().x, 1, 0.02f);
}

TEST(EnvironmentCopies, ALargeOneHasMeansOfTheTexels) {
    const Environment sharp(one_bright_texel(), 0);
    const Environment small =
        sharp.changed([](float, const Vec3& radiance) { return radiance; }, 64);
    EXPECT_NEAR(small.integral().x / sharp.integral().x, 1, 0.01f);
}

}  // namespace
}  // namespace sightline
