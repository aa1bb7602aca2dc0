#include "image/halving.h"

#include "core/srgb.h"
#include "support/images.h"
#include "support/png.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline {
namespace {

// 127.5 is between two bytes; 16-bit means are rounded down.
TEST(Halving, MeansAreThoseOfLinearLight) {
    for (const bool srgb : {false, true}) {
        Image image = pattern(2, 2, 4);
        image.bytes = {0, 255, 40, 0, 255, 255, 40, 255, 0, 255, 40, 0, 255, 255, 40, 255};
        keep_level(image, {1, srgb});
        EXPECT_EQ(image.level, 1);
        const int half = srgb ? int(std::lround(encode_srgb(0.5f) * 255)) : 127;
        EXPECT_EQ(image.bytes, (std::vector<uint8_t>{uint8_t(half), 255, 40, 127})) << srgb;
    }
}

TEST(Halving, ALevelIsHalvedFromTheOneBefore) {
    for (int channels = 1; channels <= 4; ++channels) {
        Image at_once = pattern(48, 16, channels), by_one = at_once;
        keep_level(at_once, {4, true});
        for (int i = 0; i < 4; ++i) keep_level(by_one, {1, true});
        EXPECT_EQ(at_once.bytes, by_one.bytes);
        EXPECT_EQ(at_once.level, 4);
        EXPECT_EQ(by_one.level, 4);
        EXPECT_EQ(at_once.width, 3);
        EXPECT_EQ(at_once.height, 1);
    }
}

TEST(Halving, StopsWhereASizeIsOdd) {
    EXPECT_EQ(exact_level(12, 20, 5), 2);
    EXPECT_EQ(exact_level(7, 8, 5), 0);
    EXPECT_EQ(exact_level(0, 0, 5), 0);
    EXPECT_EQ(exact_level(4096, 4096, 3), 3);
    Image image = pattern(12, 20, 3);
    keep_level(image, {5, false});
    EXPECT_EQ(image.level, 2);
    EXPECT_EQ(image.width, 3);
    EXPECT_EQ(image.height, 5);
}

Bytes png_rows(uint32_t width, uint32_t height, int bytes_per_pixel) {
    Bytes rows;
    for (uint32_t y = 0; y < height; ++y) {
        append(rows, {0});
        for (uint32_t x = 0; x < width * uint32_t(bytes_per_pixel); ++x)
            append(rows, {int((x * 31 + y * 17 + x * y) & 255)});
    }
    return rows;
}

TEST(Halving, ALevelOfAPngIsThatOfItsPixels) {
    const int bytes_of_type[] = {1, 0, 3, 1, 2, 0, 4};
    for (const int type : {0, 2, 4, 6}) {
        const Bytes file =
            Png{16, 24, 8, type, {}, {}, png_rows(16, 24, bytes_of_type[type])}.file();
        for (int level = 0; level <= 4; ++level) {
            Image means = decode_image(file, "a picture");
            keep_level(means, {level, true});
            const Image image = decode_image(file, "a picture", {}, {level, true});
            EXPECT_EQ(image.level, std::min(level, 3));
            EXPECT_EQ(image.bytes, means.bytes) << type << level;
        }
    }
}

TEST(Halving, ALevelOfAPaletteIsThatOfItsColours) {
    Bytes palette;
    for (int i = 0; i < 256; ++i) append(palette, {i, 255 - i, i / 2});
    const Bytes file = Png{8, 8, 8, 3, palette, {}, png_rows(8, 8, 1)}.file();
    Image means = decode_image(file, "a picture");
    keep_level(means, {2, true});
    EXPECT_EQ(decode_image(file, "a picture", {}, {2, true}).bytes, means.bytes);
    EXPECT_EQ(means.channels, 3);
}

TEST(Halving, SixteenBitsStayWhole) {
    const Image image = decode_image(Png{8, 8, 16, 2, {}, {}, png_rows(8, 8, 6)}.file(),
                                     "a picture", {}, {2, true});
    EXPECT_EQ(image.level, 0);
    EXPECT_EQ(image.width, 8);
    EXPECT_EQ(image.floats.size(), 8u * 8 * 3);
}

}  // namespace
}  // namespace sightline
