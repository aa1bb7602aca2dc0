// PNG and JPEG, which are decoded without OpenImageIO, against OpenImageIO; what is passed over in
// damaged files; bounded work.
#include "core/error.h"
#include "core/files.h"
#include "image/halving.h"
#include "image/image.h"
#include "image/module.h"
#include "image/sniff.h"
#include "support/png.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>
#include <time.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <random>
// libjpeg's header needs <cstdio> before it.
#include <jpeglib.h>

namespace sightline {
namespace {

/// OpenImageIO's pixels; empty if it cannot decode the file.
Image decode_by_oiio(const Bytes& file, ImageFormat format) {
    const ImageModule& module = image_module_for(format, "reference");
    ModuleMessage message{};
    ImageLayout shape{};
    void* decoder = module.open(module_format(format), file.data(), file.size(), &shape, &message);
    if (!decoder) return {};
    Image image;
    const auto values = static_cast<size_t>(shape.width) * static_cast<size_t>(shape.height) *
                        static_cast<size_t>(shape.channels);
    if (shape.floats)
        image.floats.resize(values);
    else
        image.bytes.resize(values);
    void* pixels = shape.floats ? static_cast<void*>(image.floats.data()) : image.bytes.data();
    if (module.read(decoder, pixels, &message)) {
        image.width = shape.width;
        image.height = shape.height;
        image.channels = shape.channels;
    }
    module.close(decoder);
    return image;
}

void expect_same_pixels(const Bytes& file, ImageFormat format, const std::string& what) {
    const Image reference = decode_by_oiio(file, format);
    ASSERT_FALSE(reference.empty()) << what;
    const Image image = decode_image(file, what);
    EXPECT_EQ(image.width, reference.width) << what;
    EXPECT_EQ(image.height, reference.height) << what;
    ASSERT_EQ(image.channels, reference.channels) << what;
    EXPECT_TRUE(image.bytes == reference.bytes) << what;
    EXPECT_TRUE(image.floats == reference.floats) << what;
    EXPECT_FALSE(image.damage) << what;
}

std::string decoding_message(const Bytes& file) {
    try {
        decode_image(file, "a picture");
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

int random_byte() {
    static std::mt19937 engine(7);
    return static_cast<int>(engine() & 255);
}

Bytes random_bytes(size_t count) {
    Bytes result;
    for (size_t i = 0; i < count; ++i) append(result, {random_byte()});
    return result;
}

int channels_of(int color_type) {
    return color_type == 2 ? 3 : color_type == 4 ? 2 : color_type == 6 ? 4 : 1;
}

/// Rows of random samples with filters of all types.
Bytes random_rows(uint32_t width, uint32_t height, int bits_of_pixel) {
    Bytes rows;
    if (width == 0) return rows;
    for (uint32_t y = 0; y < height; ++y) {
        append(rows, {random_byte() % 5});
        const Bytes row = random_bytes((width * static_cast<uint32_t>(bits_of_pixel) + 7) / 8);
        rows.insert(rows.end(), row.begin(), row.end());
    }
    return rows;
}

/// The seven passes of an interlaced PNG (PNG specification, 8.2).
Bytes random_passes(uint32_t width, uint32_t height, int bits_of_pixel) {
    struct Pass {
        uint32_t x, y, x_step, y_step;
    };
    Bytes rows;
    for (const Pass& p : {Pass{0, 0, 8, 8},
                          {4, 0, 8, 8},
                          {0, 4, 4, 8},
                          {2, 0, 4, 4},
                          {0, 2, 2, 4},
                          {1, 0, 2, 2},
                          {0, 1, 1, 2}}) {
        const auto count = [](uint32_t size, uint32_t first, uint32_t step) {
            return size > first ? (size - first + step - 1) / step : 0;
        };
        const Bytes pass =
            random_rows(count(width, p.x, p.x_step), count(height, p.y, p.y_step), bits_of_pixel);
        rows.insert(rows.end(), pass.begin(), pass.end());
    }
    return rows;
}

Png random_png(uint32_t width, uint32_t height, int depth, int color_type, bool transparency,
               bool interlaced) {
    const int bits = depth * channels_of(color_type);
    Png png{width, height, depth, color_type, {}, {}, {}, interlaced};
    png.rows = interlaced ? random_passes(width, height, bits) : random_rows(width, height, bits);
    if (color_type == 3) png.palette = random_bytes(size_t{3} << depth);
    if (transparency && color_type == 3) png.transparency = random_bytes(size_t{1} << (depth - 1));
    if (transparency && color_type != 3)
        for (int c = 0; c < channels_of(color_type); ++c)
            append(png.transparency, {depth == 16 ? 1 : 0, 1});
    return png;
}

TEST(Decoder, ALevelIsChargedWholeWhereTheImageIsHeldBefore) {
    const auto bytes = [](bool interlaced, int level) {
        return decoded_bytes(random_png(64, 32, 8, 2, false, interlaced).file(), level);
    };
    const uint64_t whole = 64 * 32 * 4;
    EXPECT_EQ(bytes(false, 0), whole);
    EXPECT_EQ(bytes(false, 2), whole / 16);
    EXPECT_EQ(bytes(true, 2), whole);
}

TEST(Decoder, PngsOfEveryKindHaveOpenImageIosPixels) {
    for (const auto& [color_type, depths] :
         {std::pair(0, std::vector{1, 2, 4, 8, 16}), std::pair(2, std::vector{8, 16}),
          std::pair(3, std::vector{1, 2, 4, 8}), std::pair(4, std::vector{8, 16}),
          std::pair(6, std::vector{8, 16})}) {
        for (const int depth : depths) {
            for (int variant = 0; variant < 4; ++variant) {
                const bool transparency = variant % 2 == 1 && color_type < 4;
                for (const uint32_t size : {1u, 3u, 21u}) {
                    const Png png =
                        random_png(size, size + 2, depth, color_type, transparency, variant >= 2);
                    expect_same_pixels(
                        png.file(), ImageFormat::png,
                        testing::PrintToString(std::tuple(color_type, depth, variant, size)));
                }
            }
        }
    }
}

/// How a JPEG is encoded.
struct JpegKind {
    int channels = 3;
    J_COLOR_SPACE from = JCS_RGB, to = JCS_YCbCr;
    bool progressive = false, arithmetic = false, subsampled = false;
    unsigned restart = 0;
    unsigned width = 37, height = 29;
};

/// A JPEG of noise on slopes.
Bytes jpeg(const JpegKind& kind) {
    jpeg_compress_struct info{};
    jpeg_error_mgr errors{};
    info.err = jpeg_std_error(&errors);
    jpeg_create_compress(&info);
    unsigned char* data = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&info, &data, &size);
    info.image_width = kind.width;
    info.image_height = kind.height;
    info.input_components = kind.channels;
    info.in_color_space = kind.from;
    jpeg_set_defaults(&info);
    jpeg_set_colorspace(&info, kind.to);
    jpeg_set_quality(&info, 90, TRUE);
    info.arith_code = kind.arithmetic ? TRUE : FALSE;
    info.restart_interval = kind.restart;
    if (!kind.subsampled)
        for (int c = 0; c < kind.channels; ++c)
            info.comp_info[c].h_samp_factor = info.comp_info[c].v_samp_factor = 1;
    if (kind.progressive) jpeg_simple_progression(&info);
    jpeg_start_compress(&info, TRUE);
    for (unsigned y = 0; y < info.image_height; ++y) {
        std::vector<unsigned char> row;
        for (unsigned i = 0; i < info.image_width * static_cast<unsigned>(kind.channels); ++i)
            row.push_back(static_cast<unsigned char>((3 * i + 5 * y + random_byte() / 16) & 255));
        unsigned char* rows = row.data();
        jpeg_write_scanlines(&info, &rows, 1);
    }
    jpeg_finish_compress(&info);
    jpeg_destroy_compress(&info);
    const auto bytes = std::as_bytes(std::span(data, size));
    Bytes file(bytes.begin(), bytes.end());
    std::free(data);
    return file;
}

TEST(Decoder, JpegsOfEveryKindHaveOpenImageIosPixels) {
    const JpegKind color, grey{1, JCS_GRAYSCALE, JCS_GRAYSCALE}, rgb{3, JCS_RGB, JCS_RGB},
        cmyk{4, JCS_CMYK, JCS_CMYK}, ycck{4, JCS_CMYK, JCS_YCCK};
    for (JpegKind kind : {color, grey, rgb, cmyk, ycck}) {
        for (int variant = 0; variant < 16; ++variant) {
            kind.progressive = (variant & 1) != 0;
            kind.subsampled = (variant & 2) != 0;
            kind.arithmetic = (variant & 4) != 0;
            kind.restart = (variant & 8) != 0 ? 2 : 0;
            expect_same_pixels(jpeg(kind), ImageFormat::jpeg,
                               testing::PrintToString(std::tuple(int{kind.to}, variant)));
        }
    }
}

TEST(Decoder, WhatOpenImageIoDecodesOfTheCorpusHasTheSamePixels) {
    const std::string corpus = SIGHTLINE_SOURCE_DIR "/../shared/corpus";
    if (!std::filesystem::exists(corpus)) GTEST_SKIP() << "shared/corpus is not here";
    int compared = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(corpus)) {
        if (!entry.is_regular_file() || entry.file_size() > (1 << 20)) continue;
        const std::string path = entry.path();
        const Bytes file = read_bytes(path, 1 << 20);
        const auto format = sniff_image(file);
        if (format != ImageFormat::png && format != ImageFormat::jpeg) continue;
        if (!decoding_message(file).empty()) continue;
        const Image reference = decode_by_oiio(file, *format), image = decode_image(file, path);
        if (reference.empty()) continue;
        EXPECT_TRUE(image.bytes == reference.bytes) << path;
        EXPECT_TRUE(image.floats == reference.floats) << path;
        ++compared;
    }
    EXPECT_GT(compared, 100);
}

/// A grey PNG of 16 x 16 pixels, whose IDAT chunks are `data`, with chunks of one type before them.
Bytes small_png(const Bytes& data, const std::string& type = "", const Bytes& content = {},
                int chunks = 0) {
    Bytes png = bytes({0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'});
    append_chunk(png, "IHDR", bytes({0, 0, 0, 16, 0, 0, 0, 16, 8, 0, 0, 0, 0}));
    for (int i = 0; i < chunks; ++i) append_chunk(png, type, content);
    append_chunk(png, "IDAT", data);
    append_chunk(png, "IEND", {});
    return png;
}

Bytes small_rows() { return Bytes(size_t{16} * 17); }

/// Deflate's bits, from the least significant of each byte.
class Bits {
  public:
    explicit Bits(Bytes& to) : to_(to) {}
    void put(uint32_t value, int count) {
        for (int i = 0; i < count; ++i, ++used_) {
            if (used_ % 8 == 0) to_.push_back(std::byte{0});
            if ((value >> i & 1) != 0) to_.back() |= static_cast<std::byte>(1 << used_ % 8);
        }
    }

  private:
    Bytes& to_;
    int64_t used_ = 0;
};

/// A zlib stream of the rows and `runs` runs of 258 zeros behind them (RFC 1951, 3.2.6).
Bytes with_zeros_behind(const Bytes& rows, int runs) {
    Bytes data = stored(rows);
    data[2] = std::byte{0};  // not the last block
    data.resize(data.size() - 4);
    Bytes zeros;
    Bits bits(zeros);
    bits.put(0b011, 3);       // the last block, with the fixed codes
    bits.put(0b00001100, 8);  // the byte 0
    for (int i = 0; i < runs; ++i) bits.put(0b10100011, 13);  // 258 bytes from distance 1
    bits.put(0, 7);
    data.insert(data.end(), zeros.begin(), zeros.end());
    append(data, {0, 0, 0, 0});
    return data;
}

/// The least processor time of three decodes, in seconds.
double time_to_decode(const Bytes& file) {
    const auto now = [] {
        timespec time{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    };
    double least = 1e9;
    for (int i = 0; i < 3; ++i) {
        const double begin = now();
        EXPECT_EQ(decode_image(file, "a picture").bytes.size(), 256u);
        least = std::min(least, now() - begin);
    }
    return least;
}

TEST(Decoder, NothingBehindThePixelsOfAPngIsInflated) {
    const Bytes zeros = with_zeros_behind(small_rows(), 1 << 22);  // a gigabyte
    Bytes plain = stored(small_rows());
    plain.resize(zeros.size());
    EXPECT_LT(time_to_decode(small_png(zeros)), 5 * time_to_decode(small_png(plain)));
}

TEST(Decoder, AncillaryChunksOfAPngAreNotDecoded) {
    // "a", no method but 0, then a text of a megabyte; the same bytes in a private chunk.
    Bytes text = bytes({'a', 0, 0});
    const Bytes zeros = with_zeros_behind({}, 4096);
    text.insert(text.end(), zeros.begin(), zeros.end());
    const Bytes data = stored(small_rows());
    EXPECT_LT(time_to_decode(small_png(data, "zTXt", text, 500)),
              5 * time_to_decode(small_png(data, "prIv", text, 500)));
}

TEST(Decoder, APngWithoutItsEndIsDrawnAndSaysSo) {
    const Bytes whole = small_png(stored(small_rows()));
    for (size_t cut = 1; cut <= 12; ++cut) {
        const Image image = decode_image(std::span(whole).first(whole.size() - cut), "a picture");
        EXPECT_EQ(image.bytes, std::vector<uint8_t>(256)) << cut;
        EXPECT_EQ(image.damage, ImageDamage::png_end) << cut;
        EXPECT_NE(image.damage_place, "") << cut;
    }
    const Bytes without_pixels(whole.begin(), whole.end() - 13);
    EXPECT_NE(decoding_message(without_pixels).find("truncated IDAT"), std::string::npos);
}

TEST(Decoder, AWrongChecksumOfAnAncillaryChunkIsPassedOver) {
    Bytes file = small_png(stored(small_rows()), "tEXt", bytes({'a', 0, 'b'}), 1);
    EXPECT_FALSE(decode_image(file, "a picture").damage);
    file[8 + 25 + 8] = std::byte{'c'};
    const Image image = decode_image(file, "a picture");
    EXPECT_EQ(image.damage, ImageDamage::png_checksum);
    EXPECT_EQ(image.damage_place, "wrong checksum of tEXt chunk at byte 33");
    file[8 + 4] = std::byte{'J'};
    EXPECT_NE(decoding_message(file).find("JHDR"), std::string::npos) << decoding_message(file);
}

TEST(Decoder, TheSizeThatCountsIsThatOfTheHeaderWhereverItIs) {
    // At the header's usual place is another size, which is small.
    Bytes file = bytes({0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'});
    append_chunk(file, "prIv", bytes({0, 0, 0, 1, 0, 0, 0, 1}));
    append_chunk(file, "IHDR", bytes({0, 1, 0, 0, 0, 0, 128, 0, 8, 0, 0, 0, 0}));
    append_chunk(file, "IDAT", stored(small_rows()));
    const std::string message = decoding_message(file);
    EXPECT_NE(message.find("65536 x 32768 pixels"), std::string::npos) << message;
}

TEST(Decoder, PixelsThatAreMissingInsideAPngsStreamAreAnError) {
    Bytes rows = small_rows();
    rows.resize(rows.size() - 1);
    EXPECT_NE(decoding_message(small_png(stored(rows))), "");
    EXPECT_NE(decoding_message(small_png({})), "");
    rows = small_rows();
    rows[17] = std::byte{9};  // no such filter
    EXPECT_NE(decoding_message(small_png(stored(rows))), "");
}

TEST(Decoder, AJpegWithoutItsEndIsDrawnAndSaysSo) {
    for (const bool progressive : {false, true}) {
        JpegKind kind;
        kind.progressive = progressive;
        const Bytes whole = jpeg(kind), cut(whole.begin(), whole.end() - 2);
        const Image image = decode_image(cut, "a picture");
        EXPECT_EQ(image.damage, ImageDamage::jpeg_end);
        EXPECT_TRUE(image.bytes == decode_image(whole, "a picture").bytes);
    }
}

TEST(Decoder, AProgressiveJpegWithoutItsLastScanIsAnError) {
    JpegKind kind;
    kind.progressive = true;
    Bytes file = jpeg(kind);
    const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
    // The tables of the last scan come before it.
    file.resize(text.rfind("\xff\xc4"));
    EXPECT_NE(decoding_message(file).find("between its scans"), std::string::npos)
        << decoding_message(file);
}

TEST(Decoder, ALevelOfAJpegIsCloseToTheMeansOfItsPixels) {
    for (const J_COLOR_SPACE to : {JCS_GRAYSCALE, JCS_YCbCr, JCS_YCCK}) {
        JpegKind kind{to == JCS_GRAYSCALE ? 1
                      : to == JCS_YCCK    ? 4
                                          : 3,
                      to == JCS_GRAYSCALE ? JCS_GRAYSCALE
                      : to == JCS_YCCK    ? JCS_CMYK
                                          : JCS_RGB,
                      to};
        kind.width = 128;
        kind.height = 64;
        const Bytes file = jpeg(kind);
        for (const bool srgb : {false, true}) {
            for (int level = 0; level <= 5; ++level) {
                Image means = decode_image(file, "a picture");
                keep_level(means, {level, srgb});
                const Image image = decode_image(file, "a picture", {}, {level, srgb});
                ASSERT_EQ(image.level, level);
                ASSERT_EQ(image.width, 128 >> level);
                ASSERT_EQ(image.bytes.size(), means.bytes.size());
                // As far as no scaled transform is used, the bits are the same.
                if (level <= (srgb ? 2 : 1)) {
                    EXPECT_TRUE(image.bytes == means.bytes) << level;
                }
                double sum = 0;
                for (size_t i = 0; i < image.bytes.size(); ++i)
                    sum += std::abs(int(image.bytes[i]) - int(means.bytes[i]));
                // The slopes wrap around in steps of 255, which CMYK multiplies.
                EXPECT_LE(sum / double(image.bytes.size()), 12) << level << srgb << int(to);
            }
        }
    }
}

TEST(Decoder, ATruncatedJpegHasTheSameFateAtEveryLevel) {
    for (const bool progressive : {false, true}) {
        JpegKind kind;
        kind.progressive = progressive;
        kind.width = kind.height = 64;
        const Bytes whole = jpeg(kind);
        for (size_t size = 64; size < whole.size(); size += 64) {
            const Bytes cut(whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size));
            const auto fate = [&](int level) -> std::string {
                try {
                    return decode_image(cut, "a picture", {}, {level, true}).damage ? "mended" : "";
                } catch (const Error& error) {
                    return error.what();
                }
            };
            for (const int level : {1, 3, 5}) EXPECT_EQ(fate(level), fate(0)) << size;
            EXPECT_NE(fate(0), "");
        }
    }
}

TEST(Decoder, GifsAndBmpsAreRead) {
    const Bytes gif =
        bytes({'G', 'I', 'F', '8', '9', 'a', 2, 0, 1, 0, 0x80, 0, 0, 10,   20,   30, 40, 50,
               60,  ',', 0,   0,   0,   0,   2, 0, 1, 0, 0,    2, 2, 0x44, 0x0a, 0,  ';'});
    const Image picture = decode_image(gif, "a.gif");
    ASSERT_EQ(picture.width, 2);
    ASSERT_GE(picture.channels, 3);
    EXPECT_EQ(picture.bytes[0], 10);
    EXPECT_EQ(picture.bytes[static_cast<size_t>(picture.channels) + 2], 60);
    Bytes bmp = bytes({'B', 'M', 62, 0, 0, 0, 0, 0, 0, 0, 54, 0, 0, 0,  40,
                       0,   0,   0,  2, 0, 0, 0, 1, 0, 0, 0,  1, 0, 24, 0});
    bmp.resize(54);
    append(bmp, {30, 20, 10, 60, 50, 40, 0, 0});
    EXPECT_EQ(decode_image(bmp, "a.bmp").bytes, (std::vector<uint8_t>{10, 20, 30, 40, 50, 60}));
    bmp[21] = std::byte{1};  // 2²⁴ pixels wide
    EXPECT_NE(decoding_message(bmp).find("pixels"), std::string::npos) << decoding_message(bmp);
}

}  // namespace
}  // namespace sightline
