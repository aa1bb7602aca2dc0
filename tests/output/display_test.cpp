#include "output/display.h"

#include "core/srgb.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sightline {
namespace {

constexpr ToneMap compressing[] = {ToneMap::pbr_neutral, ToneMap::aces, ToneMap::agx};

/// One pixel of beauty.
Film film_of(float r, float g, float b, float a) {
    Film film;
    film.display = film.window = {0, 0, 1, 1};
    for (const auto& [name, value] : {std::pair("R", r), {"G", g}, {"B", b}, {"A", a}}) {
        Channel& channel = film.channels.emplace_back();
        channel.name = name;
        channel.values = {value};
    }
    return film;
}

TEST(Display, SrgbEncodingHasTheStandardsValues) {
    EXPECT_EQ(encode_srgb(0), 0);
    EXPECT_EQ(encode_srgb(1), 1);
    EXPECT_NEAR(encode_srgb(0.5f), 0.735357f, 1e-6f);
    EXPECT_NEAR(encode_srgb(0.18f), 0.461356f, 1e-6f);
    EXPECT_NEAR(encode_srgb(0.001f), 0.01292f, 1e-7f);
    EXPECT_EQ(encode_srgb(-1), 0);
    EXPECT_EQ(encode_srgb(7), 1);
    EXPECT_EQ(encode_srgb(std::numeric_limits<float>::quiet_NaN()), 0);
}

TEST(Display, PbrNeutralKeepsBaseColoursLessFresnelsOffset) {
    const Vec3 color = tone_map(ToneMap::pbr_neutral, {0.5f, 0.4f, 0.3f});
    EXPECT_NEAR(color.x, 0.46f, 1e-6f);
    EXPECT_NEAR(color.y, 0.36f, 1e-6f);
    EXPECT_NEAR(color.z, 0.26f, 1e-6f);
    // Below 0.08 the offset is x - 6.25 x².
    EXPECT_NEAR(tone_map(ToneMap::pbr_neutral, Vec3(0.04f)).x, 6.25f * 0.04f * 0.04f, 1e-6f);
}

TEST(Display, PbrNeutralCompressesHighlightsAsSpecified) {
    // Grey 1: peak 0.96, above 0.76; 1 - 0.24² / (0.96 + 0.24 - 0.76).
    EXPECT_NEAR(tone_map(ToneMap::pbr_neutral, Vec3(1)).x, 1 - 0.0576f / 0.44f, 1e-6f);
    // Pure red 2: peak 2 becomes 1 - 0.0576 / 1.48, mixed to white by 1 - 1 / (0.15·Δ + 1).
    const float peak = 1 - 0.0576f / 1.48f, white = 1 - 1 / (0.15f * (2 - peak) + 1);
    const Vec3 red = tone_map(ToneMap::pbr_neutral, {2, 0, 0});
    EXPECT_NEAR(red.x, peak, 1e-6f);
    EXPECT_NEAR(red.y, peak * white, 1e-6f);
}

TEST(Display, AcesHasTheValuesOfItsFit) {
    EXPECT_NEAR(tone_map(ToneMap::aces, Vec3(0)).x, 0, 1e-4f);
    // The matrices keep grey: only the curve acts, (x(x+a)-b) / (x(cx+d)+e).
    const float x = 0.18f;
    const float expected =
        (x * (x + 0.0245786f) - 0.000090537f) / (x * (0.983729f * x + 0.432951f) + 0.238081f);
    EXPECT_NEAR(tone_map(ToneMap::aces, Vec3(x)).y, expected, 2e-5f);
}

TEST(Display, AgxMapsMiddleGreyToHalfTheDisplaysSignal) {
    EXPECT_NEAR(tone_map(ToneMap::agx, Vec3(0.18f)).y, std::pow(0.5f, 2.2f), 2e-4f);
    // White is 6.5 stops above, black 10 below.
    EXPECT_NEAR(tone_map(ToneMap::agx, Vec3(0.18f * std::exp2(6.5f))).y, 1, 1e-3f);
    EXPECT_NEAR(tone_map(ToneMap::agx, Vec3(0.18f * std::exp2(-10.0f))).y, 0, 1e-5f);
    // One stop each way, by the sigmoid's closed form.
    EXPECT_NEAR(std::pow(tone_map(ToneMap::agx, Vec3(0.36f)).y, 1 / 2.2f), 0.620926f, 5e-5f);
    EXPECT_NEAR(std::pow(tone_map(ToneMap::agx, Vec3(0.09f)).y, 1 / 2.2f), 0.379318f, 5e-5f);
}

TEST(Display, EveryToneMapIsInRangeAndRisesWithLight) {
    for (const ToneMap map : compressing) {
        float before = -1;
        for (float stops = -12; stops < 12; stops += 0.25f) {
            const float grey = tone_map(map, Vec3(std::exp2(stops))).y;
            EXPECT_GE(grey, before);
            before = grey;
            const Vec3 blue = tone_map(map, Vec3(0, 0.1f, 1) * std::exp2(stops));
            for (const float c : {blue.x, blue.y, blue.z}) {
                EXPECT_GE(c, 0);
                EXPECT_LE(c, 1);
            }
        }
    }
}

TEST(Display, ToneMapsOfNanAndInfinityAreInRange) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    for (const ToneMap map : compressing) {
        for (const Vec3& bad :
             {Vec3(nan), Vec3(infinity), Vec3(-infinity), Vec3(nan, 1, infinity)}) {
            const Vec3 color = tone_map(map, bad);
            EXPECT_TRUE(color.x >= 0 && color.x <= 1 && color.y >= 0 && color.y <= 1 &&
                        color.z >= 0 && color.z <= 1)
                << color;
        }
    }
}

TEST(Display, APictureIsExposedEncodedAndRounded) {
    const Image image = display_picture(film_of(0.25f, 0.0f, 4, 1), ToneMap::linear, 1, false);
    EXPECT_EQ(image.channels, 3);
    EXPECT_EQ(image.bytes, (std::vector<uint8_t>{188, 0, 255}));
}

TEST(Display, AlphaIsDividedOutOfTheColourBeforeTheToneMap) {
    const Image image = display_picture(film_of(0.25f, 0, 0, 0.5f), ToneMap::linear, 0, true);
    EXPECT_EQ(image.channels, 4);
    EXPECT_EQ(image.bytes, (std::vector<uint8_t>{188, 0, 0, 128}));
    const Image clear = display_picture(film_of(0.25f, 0, 0, 0), ToneMap::linear, 0, true);
    EXPECT_EQ(clear.bytes, (std::vector<uint8_t>{0, 0, 0, 0}));
}

TEST(Display, ALinearPictureIsOnlyExposed) {
    const Image image = linear_picture(film_of(0.25f, 3, 0.1f, 1), 2);
    EXPECT_EQ(image.floats, (std::vector<float>{1, 12, 0.4f}));
}

}  // namespace
}  // namespace sightline
