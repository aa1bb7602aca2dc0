#include "image/write_image.h"
#include "support/png.h"
#include "support/test_folder.h"

#include "core/error.h"
#include "core/files.h"

#include <fmt/chrono.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace sightline {
namespace {

std::string folder() { return test_folder().string() + "/"; }

std::string message_of(const Bytes& file, const ImageLimits& limits = {}) {
    try {
        decode_image(file, "a picture", limits);
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

using Values = std::vector<uint8_t>;

TEST(Image, PngKeepsItsBytesAndItsAlphaStraight) {
    const Png png{2, 1, 8, 6, {}, {}, bytes({0, 200, 100, 50, 10, 255, 0, 1, 255})};
    const Image image = decode_image(png.file(), "a.png");
    EXPECT_EQ(image.width, 2);
    EXPECT_EQ(image.height, 1);
    EXPECT_EQ(image.channels, 4);
    EXPECT_TRUE(image.floats.empty());
    EXPECT_EQ(image.bytes, (Values{200, 100, 50, 10, 255, 0, 1, 255}));
}

TEST(Image, PngRowsComeFromTheTop) {
    const Png png{1, 2, 8, 2, {}, {}, bytes({0, 1, 2, 3, 0, 4, 5, 6})};
    EXPECT_EQ(decode_image(png.file(), "a.png").bytes, (Values{1, 2, 3, 4, 5, 6}));
}

TEST(Image, PngWithSixteenBitsBecomesFloats) {
    const Png png{1, 1, 16, 2, {}, {}, bytes({0, 0xff, 0xff, 0x80, 0x00, 0, 1})};
    const Image image = decode_image(png.file(), "a.png");
    ASSERT_EQ(image.floats.size(), 3u);
    EXPECT_TRUE(image.bytes.empty());
    EXPECT_FLOAT_EQ(image.floats[0], 1.0f);
    EXPECT_FLOAT_EQ(image.floats[1], 32768.0f / 65535.0f);
    EXPECT_FLOAT_EQ(image.floats[2], 1.0f / 65535.0f);
}

TEST(Image, PngPaletteWithTransparencyBecomesRgba) {
    const Png png{2, 1, 8, 3, bytes({10, 20, 30, 40, 50, 60}), bytes({128}), bytes({0, 1, 0})};
    EXPECT_EQ(decode_image(png.file(), "a.png").bytes, (Values{40, 50, 60, 255, 10, 20, 30, 128}));
}

TEST(Image, PngPaletteOfOneBitBecomesRgb) {
    const Png png{3, 1, 1, 3, bytes({9, 8, 7, 1, 2, 3}), {}, bytes({0, 0b01000000})};
    EXPECT_EQ(decode_image(png.file(), "a.png").bytes, (Values{9, 8, 7, 1, 2, 3, 9, 8, 7}));
}

TEST(Image, PngGreyOfFourBitsIsScaledToEight) {
    const Png png{2, 1, 4, 0, {}, {}, bytes({0, 0x0f})};
    const Image image = decode_image(png.file(), "a.png");
    EXPECT_EQ(image.channels, 1);
    EXPECT_EQ(image.bytes, (Values{0, 255}));
}

TEST(Image, PngGreyWithAlphaKeepsTwoChannels) {
    const Png png{1, 1, 8, 4, {}, {}, bytes({0, 99, 3})};
    const Image image = decode_image(png.file(), "a.png");
    EXPECT_EQ(image.channels, 2);
    EXPECT_EQ(image.bytes, (Values{99, 3}));
}

Image gradient(int width, int height, int channels) {
    Image image;
    image.width = width;
    image.height = height;
    image.channels = channels;
    for (int i = 0; i < width * height * channels; ++i) {
        image.bytes.push_back(static_cast<uint8_t>(i * 7 % 256));
    }
    return image;
}

TEST(Image, LosslessFormatsReadBackBitEqual) {
    for (const char* ending : {".png", ".tif"}) {
        for (const int channels : {1, 2, 3, 4}) {
            const std::string path = folder() + "lossless" + ending;
            const Image image = gradient(5, 3, channels);
            write_image(path, image);
            const Image back = read_image(path);
            EXPECT_EQ(back.width, 5) << path;
            EXPECT_EQ(back.channels, channels) << path;
            EXPECT_EQ(back.bytes, image.bytes) << path << channels;
        }
    }
}

TEST(Image, LossyFormatsReadBackClose) {
    Image image;
    image.width = image.height = 32;
    image.channels = 4;
    for (int i = 0; i < 32 * 32; ++i) {
        for (const int value : {60 + 4 * (i % 32), 60 + 4 * (i / 32), 128, 255}) {
            image.bytes.push_back(static_cast<uint8_t>(value));
        }
    }
    for (const char* ending : {".jpg", ".webp"}) {
        const std::string path = folder() + "lossy" + ending;
        write_image(path, image);
        const Image back = read_image(path);
        ASSERT_EQ(back.width, 32);
        ASSERT_EQ(back.bytes.size() % 1024, 0u);
        const size_t stride = back.bytes.size() / 1024;
        for (size_t i = 0; i < 1024; ++i) {
            for (size_t c = 0; c < 3; ++c) {
                EXPECT_NEAR(back.bytes[i * stride + c], image.bytes[i * 4 + c], 10) << path;
            }
        }
    }
}

TEST(Image, HdrKeepsLinearFloatsWithinItsPrecision) {
    Image image;
    image.width = 16;
    image.height = 2;
    image.channels = 3;
    for (int pixel = 0; pixel < 32; ++pixel)
        image.floats.insert(image.floats.end(), 3, std::exp2(static_cast<float>(pixel - 16)));
    const std::string path = folder() + "a.hdr";
    write_image(path, image);
    const Image back = read_image(path);
    ASSERT_EQ(back.floats.size(), image.floats.size());
    for (size_t i = 0; i < 96; ++i) {
        EXPECT_NEAR(back.floats[i] / image.floats[i], 1.0f, 1.0f / 128) << i;
    }
}

/// A Radiance file of 2 x 3 pixels in the order of the resolution string, whose axes are `first`
/// and `second`. The red of the pixel in row y and column x of the upright picture is
/// 1 + x + 10 y. Scanlines of fewer than 8 pixels are not compressed.
Bytes radiance_file(const std::string& first, const std::string& second) {
    const bool by_columns = first[1] == 'X';
    const int width = 2, height = 3;
    const int lines = by_columns ? width : height, length = by_columns ? height : width;
    const std::string header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + first + " " +
                               std::to_string(lines) + " " + second + " " + std::to_string(length) +
                               "\n";
    Bytes file;
    for (const char c : header) append(file, {c});
    for (int line = 0; line < lines; ++line) {
        for (int i = 0; i < length; ++i) {
            int x = by_columns ? line : i, y = by_columns ? i : line;
            if ((by_columns ? first : second)[0] == '-') x = width - 1 - x;
            if ((by_columns ? second : first)[0] == '+') y = height - 1 - y;
            append(file, {1 + x + 10 * y, 0, 0, 128 + 8});
        }
    }
    return file;
}

TEST(Image, AllEightOrientationsOfHdrAreReadUpright) {
    for (const auto& [first, second] :
         {std::pair("-Y", "+X"), std::pair("-Y", "-X"), std::pair("+Y", "+X"),
          std::pair("+Y", "-X"), std::pair("+X", "-Y"), std::pair("-X", "-Y"),
          std::pair("+X", "+Y"), std::pair("-X", "+Y")}) {
        const Image image = decode_image(radiance_file(first, second), "a.hdr");
        ASSERT_EQ(image.width, 2) << first << second;
        ASSERT_EQ(image.height, 3) << first << second;
        for (int y = 0; y < 3; ++y) {
            for (int x = 0; x < 2; ++x) {
                const auto at = static_cast<size_t>(3 * (2 * y + x));
                // Some readers add half a step of the mantissa.
                EXPECT_NEAR(image.floats[at], static_cast<float>(1 + x + 10 * y), 0.5f)
                    << first << second << x << y;
            }
        }
    }
}

TEST(Image, AnHdrWithOneAxisTwiceIsAnError) {
    EXPECT_FALSE(message_of(radiance_file("-Y", "+Y")).empty());
    EXPECT_FALSE(message_of(radiance_file("+X", "-X")).empty());
}

/// A lossless WebP of one colour: each of its five prefix codes has one symbol and takes no bits
/// (RFC 9649, 3.7).
Bytes plain_webp(uint32_t width, uint32_t height, const std::array<uint32_t, 4>& rgba) {
    std::vector<bool> bits;
    const auto put = [&](uint32_t value, int count) {
        for (int i = 0; i < count; ++i) bits.push_back((value >> i & 1) != 0);
    };
    put(0x2f, 8);
    put(width - 1, 14);
    put(height - 1, 14);
    put(1, 1);  // alpha is used
    put(0, 6);  // version, no transform, no colour cache, no meta prefix codes
    for (const uint32_t symbol : {rgba[1], rgba[0], rgba[2], rgba[3]}) {
        put(0b101, 3);  // simple, one symbol, of 8 bits
        put(symbol, 8);
    }
    put(0b0001, 4);  // the same of 1 bit, for distances
    bits.resize((bits.size() + 15) / 16 * 16 + 16);
    const int size = static_cast<int>(bits.size() / 8);
    Bytes file = bytes({'R', 'I', 'F', 'F', size + 12, 0,   0,    0, 'W', 'E',
                        'B', 'P', 'V', 'P', '8',       'L', size, 0, 0,   0});
    for (size_t i = 0; i < bits.size(); i += 8) {
        int byte = 0;
        for (size_t k = 0; k < 8; ++k) byte |= (bits[i + k] ? 1 : 0) << k;
        append(file, {byte});
    }
    return file;
}

TEST(Image, WebpKeepsColoursOfTransparentPixels) {
    const Image image = decode_image(plain_webp(2, 1, {10, 200, 30, 0}), "a.webp");
    EXPECT_EQ(image.channels, 4);
    EXPECT_EQ(image.bytes, (Values{10, 200, 30, 0, 10, 200, 30, 0}));
    EXPECT_EQ(decode_image(plain_webp(1, 1, {255, 100, 30, 64}), "a.webp").bytes,
              (Values{255, 100, 30, 64}));
}

TEST(Image, WebpIsWrittenWithStraightAlpha) {
    Image image;
    image.width = image.height = 16;
    image.channels = 4;
    for (int i = 0; i < 256; ++i) {
        for (const int value : {200, 100, 50, 64})
            image.bytes.push_back(static_cast<uint8_t>(value));
    }
    write_image(folder() + "alpha.webp", image);
    const Image back = read_image(folder() + "alpha.webp");
    ASSERT_EQ(back.bytes.size(), image.bytes.size());
    for (size_t i = 0; i < image.bytes.size(); ++i) {
        ASSERT_NEAR(back.bytes[i], image.bytes[i], 4) << i;
    }
}

TEST(Image, AWebpBombIsRejectedByItsHeader) {
    const std::string message = message_of(plain_webp(16383, 16383, {0, 0, 0, 0}));
    EXPECT_NE(message.find("16383 x 16383"), std::string::npos) << message;
}

TEST(Image, EqualImagesGiveEqualFilesWithoutATime) {
    // A time of writing would begin with the year, as in "2026:" (TIFF) or "2026-" (XMP).
    const std::string year = fmt::format("{:%Y}", fmt::localtime(std::time(nullptr)));
    for (const char* extension : {".png", ".tif", ".webp", ".jpg"}) {
        const std::string path = folder() + "again" + extension;
        write_image(path, gradient(5, 5, 3));
        const Bytes first = read_bytes(path, 1 << 20);
        write_image(path, gradient(5, 5, 3));
        EXPECT_EQ(read_bytes(path, 1 << 20), first) << extension;
        const std::string text(reinterpret_cast<const char*>(first.data()), first.size());
        EXPECT_EQ(text.find(year + ":"), std::string::npos) << extension;
        EXPECT_EQ(text.find(year + "-"), std::string::npos) << extension;
    }
}

TEST(Image, ManyThreadsDecodeAtOnce) {
    const Bytes file = Png{1, 1, 8, 2, {}, {}, bytes({0, 1, 2, 3})}.file();
    std::vector<std::thread> threads;
    for (int i = 0; i < 8; ++i) {
        threads.emplace_back([&] {
            for (int k = 0; k < 20; ++k) {
                EXPECT_EQ(decode_image(file, "a.png").bytes, (Values{1, 2, 3}));
            }
        });
    }
    for (auto& thread : threads) thread.join();
}

TEST(Image, UnknownFormatsAreRejectedByName) {
    EXPECT_NE(message_of(bytes({'B', 'P', 'G', 0})).find("a picture: not a PNG"),
              std::string::npos);
    EXPECT_FALSE(message_of({}).empty());
    EXPECT_THROW(read_image("/nonexistent.png"), Error);
}

TEST(Image, APngBombIsRejectedByItsHeader) {
    const std::string message = message_of(Png{100000, 100000, 8, 6, {}, {}, bytes({0, 0})}.file());
    EXPECT_NE(message.find("100000 x 100000"), std::string::npos) << message;
    EXPECT_FALSE(message_of(Png{0, 5, 8, 6, {}, {}, bytes({0, 0})}.file()).empty());
}

TEST(Image, AJpegWithTooManyScansIsRejected) {
    // A frame header of 16 x 16 pixels and nothing but starts of scans.
    Bytes file = bytes({0xff, 0xd8, 0xff, 0xc2, 0, 11, 8, 0, 16, 0, 16, 1, 1, 0x11, 0});
    for (int i = 0; i < 1000; ++i) append(file, {0xff, 0xda, 0, 8, 1, 1, 0, 0, 0, 0});
    EXPECT_NE(message_of(file).find("scans"), std::string::npos) << message_of(file);
}

TEST(Image, TheCallerLimitsThePixels) {
    const Bytes file = Png{2, 1, 8, 2, {}, {}, bytes({0, 1, 2, 3, 4, 5, 6})}.file();
    EXPECT_TRUE(message_of(file, {.max_pixels = 2}).empty());
    EXPECT_FALSE(message_of(file, {.max_pixels = 1}).empty());
}

TEST(Image, EveryTruncationIsAnError) {
    const std::string start = folder() + "whole";
    write_image(start + ".png", gradient(9, 7, 4));
    write_image(start + ".tif", gradient(9, 7, 3));
    write_image(start + ".webp", gradient(9, 7, 4));
    write_image(start + ".jpg", gradient(9, 7, 3));
    // `tail`: bytes after the last pixel, the end of a PNG or JPEG and the text tags of a TIFF.
    for (const auto& [ending, tail] : {std::pair(".png", 12), std::pair(".webp", 0),
                                       std::pair(".jpg", 2), std::pair(".tif", 40)}) {
        const Bytes file = read_bytes(start + ending, 1 << 20);
        const size_t needed = file.size() - static_cast<size_t>(tail);
        for (size_t size = 0; size < needed; ++size) {
            EXPECT_FALSE(
                message_of(Bytes(file.begin(), file.begin() + static_cast<long>(size))).empty())
                << ending << " cut at " << size << " of " << file.size();
        }
    }
}

TEST(Image, AChangedByteOfAPngIsAnErrorWithTheChunksName) {
    Bytes file = Png{1, 1, 8, 2, {}, {}, bytes({0, 1, 2, 3})}.file();
    file[8 + 25 + 8 + 9] ^= std::byte{1};
    const std::string message = message_of(file);
    EXPECT_NE(message.find("checksum of IDAT"), std::string::npos) << message;
}

TEST(Image, AnExrWithAnAbsurdWindowOrTileIsRejectedByItsHeader) {
    const auto exr = [](const std::string& name, const std::string& type,
                        std::initializer_list<uint32_t> values) {
        Bytes file = bytes({0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0});
        for (const std::string& word : {name, type}) {
            for (const char c : word) file.push_back(static_cast<std::byte>(c));
            append(file, {0});
        }
        append(file, {static_cast<int>(values.size()) * 4, 0, 0, 0});
        for (const uint32_t value : values) {
            for (int shift = 0; shift < 32; shift += 8) {
                file.push_back(static_cast<std::byte>(value >> shift));
            }
        }
        append(file, {0});
        return file;
    };
    for (const uint32_t far : {100663296u, 0x7fffffffu}) {
        EXPECT_NE(message_of(exr("dataWindow", "box2i", {0, 0, far, 0})).find("pixels"),
                  std::string::npos);
        EXPECT_NE(message_of(exr("displayWindow", "box2i", {0, 0, far, 0})).find("pixels"),
                  std::string::npos);
        EXPECT_NE(message_of(exr("tiles", "tiledesc", {far, 1, 0})).find("pixels"),
                  std::string::npos);
    }
    EXPECT_NE(message_of(exr("dataWindow", "box2i", {0x80000000u, 0, 0, 0})).find("pixels"),
              std::string::npos);
}

}  // namespace
}  // namespace sightline
