#include "image/compare.h"

#include "core/error.h"
#include "image/flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sightline {
namespace {

Image plain(int width, int height, const std::vector<uint8_t>& pixel) {
    Image image;
    image.width = width;
    image.height = height;
    image.channels = static_cast<int>(pixel.size());
    for (int i = 0; i < width * height; ++i) {
        for (const uint8_t value : pixel) image.bytes.push_back(value);
    }
    return image;
}

Image float_picture(std::vector<float> values) {
    Image image;
    image.width = static_cast<int>(values.size());
    image.height = image.channels = 1;
    image.floats = std::move(values);
    return image;
}

/// Smooth colours with a hard edge.
Image scenery(int size) {
    Image image = plain(size, size, {0, 0, 0});
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            const auto at = static_cast<size_t>(3 * (y * size + x));
            image.bytes[at] = static_cast<uint8_t>(4 * x % 256);
            image.bytes[at + 1] = static_cast<uint8_t>(2 * y % 256);
            image.bytes[at + 2] = x > y ? 200 : 40;
        }
    }
    return image;
}

TEST(Compare, EqualImagesDoNotDiffer) {
    const Difference d = compare_images(scenery(32), scenery(32));
    EXPECT_EQ(d.rmse, 0);
    EXPECT_EQ(d.max_abs, 0);
    EXPECT_EQ(d.nonfinite, 0u);
    EXPECT_EQ(d.flip_mean, 0);
}

TEST(Compare, DifferencesHaveTheirKnownMean) {
    const Difference d =
        compare_images(float_picture({1, 2, 3, 4}), float_picture({1, 2.5f, 3, 2}));
    EXPECT_DOUBLE_EQ(d.rmse, std::sqrt((0.25 + 4) / 4));
    EXPECT_DOUBLE_EQ(d.max_abs, 2);
    EXPECT_DOUBLE_EQ(compare_images(plain(2, 2, {0}), plain(2, 2, {51})).rmse, 0.2);
}

TEST(Compare, NanAndInfinityExceedEveryTolerance) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    for (const auto& [a, b] :
         {std::pair(nan, 0.0f), {0.0f, nan}, {nan, nan}, {infinity, 1.0f}, {-infinity, infinity}}) {
        const Difference d = compare_images(float_picture({a, 1}), float_picture({b, 1}));
        EXPECT_EQ(d.nonfinite, 1u);
        EXPECT_TRUE(std::isinf(d.rmse));
        EXPECT_TRUE(std::isinf(d.max_abs));
        EXPECT_TRUE(std::isfinite(d.flip_mean));
    }
    const Difference same = compare_images(float_picture({infinity}), float_picture({infinity}));
    EXPECT_EQ(same.rmse, 0);
    EXPECT_EQ(same.nonfinite, 1u);
}

TEST(Compare, ImagesOfDifferentShapeAreRejected) {
    EXPECT_THROW(compare_images(plain(2, 2, {0}), plain(2, 3, {0})), Error);
    EXPECT_THROW(compare_images(plain(2, 2, {0}), plain(2, 2, {0, 0, 0})), Error);
    EXPECT_THROW(compare_images(plain(1, 1, {0}), float_picture({0})), Error);
    EXPECT_THROW(compare_images({}, {}), Error);
}

TEST(Compare, FlipOfPlainColoursIsTheRemappedHyabDistance) {
    // Green against blue is the largest possible distance, by definition 1.
    EXPECT_NEAR(flip(plain(8, 8, {0, 255, 0}), plain(8, 8, {0, 0, 255}))[9], 1, 1e-4f);
    // Black against white: 100^0.7 of 203.29^0.7, above the knee at 0.4.
    const double largest = std::pow(203.29, 0.7), knee = 0.4 * largest;
    const double expected = 0.95 + 0.05 * (std::pow(100, 0.7) - knee) / (largest - knee);
    EXPECT_NEAR(flip(plain(8, 8, {0, 0, 0}), plain(8, 8, {255, 255, 255}))[9], expected, 1e-4);
    // Two greys 10 of lightness apart: below the knee.
    const float l60 = std::pow(76.0f / 116, 3.0f), l50 = std::pow(66.0f / 116, 3.0f);
    EXPECT_NEAR(flip(float_picture({l60}), float_picture({l50}))[0],
                0.95 * std::pow(10, 0.7) / knee, 1e-4);
}

TEST(Compare, FlipEqualsThePapersUnseparatedFilters) {
    Image a = plain(20, 20, {0, 0, 0});
    for (int i = 0; i < 400; ++i) {
        const auto at = static_cast<size_t>(3 * i);
        a.bytes[at] = static_cast<uint8_t>(7 * (i % 20));
        a.bytes[at + 1] = static_cast<uint8_t>(11 * (i / 20));
        a.bytes[at + 2] = i % 20 > i / 20 ? 200 : 40;
    }
    Image b = a;
    for (size_t y = 5; y < 9; ++y) {
        for (size_t x = 6; x < 12; ++x) {
            b.bytes[3 * (20 * y + x)] ^= 255;
            b.bytes[3 * (20 * y + x) + 2] = 90;
        }
    }
    // Computed independently in double precision with two-dimensional filters.
    EXPECT_NEAR(compare_images(a, b).flip_mean, 0.1034229, 1e-5);
}

TEST(Compare, FlipIgnoresImperceptibleNoise) {
    Image stripes = plain(64, 64, {128, 128, 128}), coarse = stripes;
    for (size_t i = 0; i < stripes.bytes.size(); ++i) {
        const size_t x = i / 3 % 64;
        stripes.bytes[i] = static_cast<uint8_t>(x % 2 ? 120 : 136);
        coarse.bytes[i] = static_cast<uint8_t>(x / 32 ? 120 : 136);
    }
    const Image grey = plain(64, 64, {128, 128, 128});
    const Difference fine = compare_images(grey, stripes), wide = compare_images(grey, coarse);
    EXPECT_DOUBLE_EQ(fine.rmse, wide.rmse);
    EXPECT_LT(fine.flip_mean, 0.3 * wide.flip_mean);
}

TEST(Compare, FlipIsSymmetricAndGrowsWithTheDifference) {
    const Image a = scenery(48);
    double before = 0;
    for (const int amount : {8, 32, 100}) {
        Image b = a;
        for (auto& byte : b.bytes) byte = static_cast<uint8_t>(std::min(255, byte + amount));
        const double mean = compare_images(a, b).flip_mean;
        EXPECT_GT(mean, before);
        EXPECT_NEAR(mean, compare_images(b, a).flip_mean, 1e-6);
        before = mean;
    }
    EXPECT_LT(before, 1);
}

}  // namespace
}  // namespace sightline
