#include "shade/environment.h"
#include "shade/studio.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>

namespace sightline {
namespace {

Image picture(int width, int height, const std::function<Vec3(int, int)>& color) {
    Image image;
    image.width = width;
    image.height = height;
    image.channels = 3;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const Vec3 c = color(x, y);
            image.floats.insert(image.floats.end(), {c.x, c.y, c.z});
        }
    }
    return image;
}

Image random_picture(unsigned seed) {
    std::mt19937 generator(seed);
    std::exponential_distribution<float> value(1);
    return picture(32, 16, [&](int x, int) {
        return x < 4 ? Vec3(0) : Vec3(value(generator), value(generator), value(generator));
    });
}

/// Calls `visit(direction, solid angle)` on a fine grid over the sphere.
template <class Visit>
void over_sphere(int rows, const Visit& visit) {
    for (int i = 0; i < rows; ++i) {
        const float theta = pi * (static_cast<float>(i) + 0.5f) / static_cast<float>(rows);
        for (int j = 0; j < 2 * rows; ++j) {
            const float phi = pi * (static_cast<float>(j) + 0.5f) / static_cast<float>(rows);
            const float step = pi / static_cast<float>(rows);
            visit(Vec3(std::cos(phi) * std::sin(theta), std::cos(theta),
                       std::sin(phi) * std::sin(theta)),
                  step * step * std::sin(theta));
        }
    }
}

TEST(Environment, IsOrientedAsInThreeJs) {
    // u = ½ + atan2(z, x)/2π, v from the top = acos(y)/π
    const Environment env(
        picture(8, 4,
                [](int x, int y) { return Vec3(static_cast<float>(x), static_cast<float>(y), 0); }),
        0);
    const auto at = [&](float x, float y, float z) {
        return env.radiance(normalize(Vec3(x, y, z)));
    };
    EXPECT_NEAR(at(1, 0, 0).x, 3.5f, 1e-4f);   // the middle of the image
    EXPECT_NEAR(at(0, 0, 1).x, 5.5f, 1e-4f);   // three quarters
    EXPECT_NEAR(at(0, 0, -1).x, 1.5f, 1e-4f);  // one quarter
    EXPECT_NEAR(at(1, 0, 0).y, 1.5f, 1e-4f);
    EXPECT_NEAR(at(0, 1, 0).y, 0, 1e-4f);
    EXPECT_NEAR(at(0, -1, 0).y, 3, 1e-4f);
}

TEST(Environment, InfinityIsTheLargestHalfAndNanIsBlack) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    const Vec3 texels[] = {{infinity, 2, 3},
                           {nan, infinity, -1},
                           {-infinity, nan, 5},
                           {std::numeric_limits<float>::max(), 0, 0}};
    const Environment env(picture(4, 2, [&](int x, int) { return texels[x]; }), 0);
    EXPECT_EQ(env.overflowed_texels(), 6u);
    const Vec3 expected[] = {{65504, 2, 3}, {0, 65504, 0}, {0, 0, 5}, {65504, 0, 0}};
    for (int x = 0; x < 4; ++x) {
        const float phi = 2 * pi * ((static_cast<float>(x) + 0.5f) / 4 - 0.5f);
        const Vec3 radiance = env.radiance({std::cos(phi), 0, std::sin(phi)});
        // Between texels the lookup is off by a few roundings of its angle.
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(radiance[c], expected[x][c], 0.5f) << x << c;
    }
    const Environment::Sample sample = env.sample({0.3f, 0.6f});
    EXPECT_TRUE(sample.pdf > 0 && std::isfinite(sample.pdf));
    EXPECT_TRUE(std::isfinite(env.pdf(sample.wi)));
}

TEST(Environment, RotatesAboutY) {
    const Image image = random_picture(1);
    const Environment still(image, 0), turned(image, pi / 2);
    // A quarter turn about +y takes +z to +x.
    const Vec3 before = still.radiance(normalize(Vec3(0.2f, 0.3f, 1)));
    const Vec3 after = turned.radiance(normalize(Vec3(1, 0.3f, -0.2f)));
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(before[i], after[i], 1e-4f);
}

TEST(Environment, InterpolatesAcrossTheSeam) {
    const Environment env(random_picture(2), 0);
    const Vec3 a = env.radiance(normalize(Vec3(-1, 0.1f, 1e-5f)));
    const Vec3 b = env.radiance(normalize(Vec3(-1, 0.1f, -1e-5f)));
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-3f);
}

TEST(Environment, PdfIntegratesToOne) {
    for (const float rotation : {0.0f, 1.0f}) {
        const Environment env(random_picture(3), rotation);
        double sum = 0;
        over_sphere(512, [&](const Vec3& d, float solid_angle) {
            sum += static_cast<double>(env.pdf(d) * solid_angle);
        });
        EXPECT_NEAR(sum, 1, 2e-3);
    }
}

TEST(Environment, SamplingReproducesTheMean) {
    const Environment env(random_picture(4), 0.7f);
    Vec3d truth(0);
    over_sphere(512, [&](const Vec3& d, float solid_angle) {
        truth += Vec3d(env.radiance(d) * solid_angle);
    });
    Vec3d estimate(0);
    const int n = 300000;
    std::mt19937 generator(6);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (int i = 0; i < n; ++i) {
        const Environment::Sample s = env.sample({uniform(generator), uniform(generator)});
        ASSERT_GT(s.pdf, 0);
        ASSERT_NEAR(s.wi.length(), 1, 1e-5f);
        if (i % 100 == 0) {
            ASSERT_NEAR(env.pdf(s.wi) / s.pdf, 1, 2e-3f);
            ASSERT_NEAR(env.radiance(s.wi).y, s.radiance.y, 1e-3f);
        }
        estimate += Vec3d(s.radiance / s.pdf) / n;
    }
    // Five standard deviations of this many samples.
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(estimate[i] / truth[i], 1, 5e-3);
}

TEST(Environment, LuminanceOverPdfIsNearlyConstant) {
    // The pdf follows the luminance within texels, too, so one bright texel makes no fireflies.
    const Environment env(
        picture(64, 32, [](int x, int y) { return Vec3(x == 20 && y == 9 ? 1e5f : 0.1f); }), 0);
    std::mt19937 generator(5);
    std::uniform_real_distribution<float> uniform(0, 1);
    float low = 1e30f, high = 0;
    for (int i = 0; i < 20000; ++i) {
        const Environment::Sample s = env.sample({uniform(generator), uniform(generator)});
        low = std::min(low, luminance(s.radiance) / s.pdf);
        high = std::max(high, luminance(s.radiance) / s.pdf);
    }
    EXPECT_LT(high / low, 2.1f);
}

TEST(Environment, WithoutLightHasNothingToSample) {
    const Environment env(picture(4, 2, [](int, int) { return Vec3(0); }), 0);
    EXPECT_EQ(env.sample({0.3f, 0.6f}).pdf, 0);
    EXPECT_EQ(env.pdf(Vec3(0, 0, 1)), 0);
}

TEST(Environment, ReplacesNanAndNegativeValuesByBlack) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    const Environment env(
        picture(8, 4,
                [&](int x, int) {
                    return x == 0 ? Vec3(nan) : x == 1 ? Vec3(-inf) : x == 2 ? Vec3(-5) : Vec3(1);
                }),
        0);
    over_sphere(16, [&](const Vec3& d, float) {
        const Vec3 c = env.radiance(d);
        EXPECT_TRUE(c.x >= 0 && c.x <= 1);
        EXPECT_TRUE(std::isfinite(env.pdf(d)));
    });
}

TEST(Environment, DecodesEightBitImagesFromSrgb) {
    Image image;
    image.width = image.height = 1;
    image.channels = 3;
    image.bytes = {188, 255, 0};
    const Vec3 c = Environment(image, 0).radiance(Vec3(0, 0, 1));
    EXPECT_NEAR(c.x, 0.5029f, 1e-3f);
    EXPECT_EQ(c.y, 1);
    EXPECT_EQ(c.z, 0);
}

TEST(Environment, StudioIsNeutralAndOfMediumBrightness) {
    const Environment env(light_image("studio"), 0);
    Vec3 mean(0);
    over_sphere(64, [&](const Vec3& d, float solid_angle) {
        mean += env.radiance(d) * (solid_angle / (4 * pi));
    });
    EXPECT_NEAR(mean.x / mean.y, 1, 0.02f);
    EXPECT_NEAR(mean.z / mean.y, 1, 0.02f);
    EXPECT_GT(mean.y, 0.5f);
    EXPECT_LT(mean.y, 1.2f);
}

}  // namespace
}  // namespace sightline
