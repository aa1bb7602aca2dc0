#include "shade/texture.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace sightline {
namespace {

Image byte_image(int width, int height, int channels, std::vector<uint8_t> bytes) {
    Image image;
    image.width = width;
    image.height = height;
    image.channels = channels;
    image.bytes = std::move(bytes);
    return image;
}

Texture sampler(Wrap wrap, Filter mag = Filter::linear, Filter min = Filter::linear_mipmap_linear) {
    Texture t;
    t.wrap_s = t.wrap_t = wrap;
    t.mag = mag;
    t.min = min;
    return t;
}

Vec4 sample(const TextureImage& image, const Texture& t, Vec2 uv, const TextureFootprint& f) {
    TextureLookup lookup;
    image.locate(t, uv, f, lookup);
    return image.read(lookup);
}

/// A round footprint.
Vec4 sample(const TextureImage& image, const Texture& t, Vec2 uv, float width) {
    return sample(image, t, uv, {width * width, 0, width * width});
}

/// A footprint with an axis `along` and one of the length `across` at right angles to it.
TextureFootprint footprint(Vec2 along, float across) {
    const Vec2 other = Vec2(-along.y, along.x) * (across / along.length());
    return {along.x * along.x + other.x * other.x, along.x * along.y + other.x * other.y,
            along.y * along.y + other.y * other.y};
}

/// Red of a row of texels 0, 51, 102, … at u.
float red(const Image& image, const Texture& t, float u, float footprint = 0) {
    return sample(TextureImage(image, false, true), t, {u, 0.5f}, footprint).x * 255;
}

TEST(Texture, ReadsTexelsAtTheirCentres) {
    const Image row = byte_image(4, 1, 1, {0, 51, 102, 255});
    for (const Filter mag : {Filter::nearest, Filter::linear}) {
        const Texture t = sampler(Wrap::clamp_to_edge, mag);
        EXPECT_NEAR(red(row, t, 0.125f), 0, 1e-3f);
        EXPECT_NEAR(red(row, t, 0.375f), 51, 1e-3f);
        EXPECT_NEAR(red(row, t, 0.875f), 255, 1e-3f);
    }
    EXPECT_NEAR(red(row, sampler(Wrap::clamp_to_edge), 0.25f), 25.5f, 1e-3f);
    EXPECT_NEAR(red(row, sampler(Wrap::clamp_to_edge, Filter::nearest), 0.24f), 0, 1e-3f);
    EXPECT_NEAR(red(row, sampler(Wrap::clamp_to_edge, Filter::nearest), 0.26f), 51, 1e-3f);
}

TEST(Texture, HasRowZeroAtVZero) {
    const Image t_image = byte_image(1, 2, 1, {10, 200});
    const TextureImage t(t_image, false, false);
    EXPECT_NEAR(sample(t, sampler(Wrap::clamp_to_edge), {0.5f, 0.25f}, 0).x * 255, 10, 1e-3f);
    EXPECT_NEAR(sample(t, sampler(Wrap::clamp_to_edge), {0.5f, 0.75f}, 0).x * 255, 200, 1e-3f);
}

TEST(Texture, WrapsByTheModeOfTheSampler) {
    const Image row = byte_image(4, 1, 1, {0, 51, 102, 255});
    const Texture repeat = sampler(Wrap::repeat), clamp = sampler(Wrap::clamp_to_edge);
    const Texture mirror = sampler(Wrap::mirrored_repeat);
    for (const float u : {0.1f, 0.375f, 0.6f, 0.9f}) {
        EXPECT_NEAR(red(row, repeat, u + 3), red(row, repeat, u), 0.01f);
        EXPECT_NEAR(red(row, repeat, u - 2), red(row, repeat, u), 0.01f);
        EXPECT_NEAR(red(row, mirror, -u), red(row, mirror, u), 0.01f);
        EXPECT_NEAR(red(row, mirror, 2 - u), red(row, mirror, u), 0.01f);
        EXPECT_NEAR(red(row, mirror, 2 + u), red(row, mirror, u), 0.01f);
    }
    EXPECT_NEAR(red(row, clamp, -0.7f), 0, 1e-3f);
    EXPECT_NEAR(red(row, clamp, 1.7f), 255, 1e-3f);
    // Exactly on the border: a repeated image blends both ends, the others do not.
    EXPECT_NEAR(red(row, repeat, 0), 127.5f, 1e-3f);
    EXPECT_NEAR(red(row, repeat, 1), 127.5f, 1e-3f);
    EXPECT_NEAR(red(row, clamp, 1), 255, 1e-3f);
    EXPECT_NEAR(red(row, mirror, 1), 255, 1e-3f);
}

TEST(Texture, WrapsEachAxisByItsOwnMode) {
    const Image t_image = byte_image(2, 2, 1, {0, 255, 0, 255});
    const TextureImage t(t_image, false, false);
    Texture s = sampler(Wrap::repeat, Filter::nearest);
    s.wrap_t = Wrap::clamp_to_edge;
    EXPECT_EQ(sample(t, s, {1.25f, 5}, 0).x, 0);
    EXPECT_EQ(sample(t, s, {1.75f, -5}, 0).x, 1);
}

TEST(Texture, DecodesSrgbBeforeFiltering) {
    const Image t_image = byte_image(2, 1, 3, {0, 188, 255, 255, 188, 255});
    const TextureImage t(t_image, true, true);
    const Vec4 middle = sample(t, sampler(Wrap::clamp_to_edge), {0.5f, 0.5f}, 0);
    EXPECT_NEAR(middle.x, 0.5f, 1e-6f);      // the mean of 0 and 1 in light, not 0.21
    EXPECT_NEAR(middle.y, 0.50289f, 1e-4f);  // IEC 61966-2-1 of 188
    EXPECT_EQ(middle.w, 1);
    const Vec4 coarse = sample(t, sampler(Wrap::clamp_to_edge), {0.5f, 0.5f}, 2);
    EXPECT_NEAR(coarse.x, 0.5029f, 1e-3f);  // 0.5 of light in eight bits of sRGB
}

TEST(Texture, LeavesAlphaLinear) {
    const Image t_image = byte_image(1, 1, 4, {128, 128, 128, 128});
    const TextureImage t(t_image, true, false);
    const Vec4 v = sample(t, sampler(Wrap::repeat), {0.5f, 0.5f}, 0);
    EXPECT_NEAR(v.x, 0.21586f, 1e-4f);
    EXPECT_NEAR(v.w, 128 / 255.0f, 1e-6f);
}

TEST(Texture, CopiesGreyToRgbAndFillsAlpha) {
    const Texture s = sampler(Wrap::repeat);
    const Image grey_image = byte_image(1, 1, 1, {51});
    const TextureImage grey(grey_image, false, false);
    const Image grey_alpha_image = byte_image(1, 1, 2, {51, 102});
    const TextureImage grey_alpha(grey_alpha_image, false, false);
    const Image rgb_image = byte_image(1, 1, 3, {0, 51, 102});
    const TextureImage rgb(rgb_image, false, false);
    EXPECT_EQ(sample(grey, s, {0, 0}, 0), Vec4(0.2f, 0.2f, 0.2f, 1));
    EXPECT_EQ(sample(grey_alpha, s, {0, 0}, 0), Vec4(0.2f, 0.2f, 0.2f, 0.4f));
    EXPECT_EQ(sample(rgb, s, {0, 0}, 0), Vec4(0, 0.2f, 0.4f, 1));
}

TEST(Texture, ReadsSixteenBitImagesAsFloats) {
    Image image;
    image.width = image.height = 1;
    image.channels = 2;
    image.floats = {0.5f, 0.25f};
    const Vec4 linear = sample(TextureImage(image, false, true), sampler(Wrap::repeat), {0, 0}, 0);
    const Vec4 srgb = sample(TextureImage(image, true, true), sampler(Wrap::repeat), {0, 0}, 0);
    EXPECT_EQ(linear, Vec4(0.5f, 0.5f, 0.5f, 0.25f));
    EXPECT_NEAR(srgb.x, 0.21404f, 1e-4f);
    EXPECT_EQ(srgb.w, 0.25f);
}

TEST(Texture, KeepsItsMeanInEveryLevelWhateverItsSize) {
    std::mt19937 generator(1);
    for (const auto& [width, height] : {std::pair(64, 64), {37, 21}, {1, 13}, {100, 3}}) {
        Image image = byte_image(width, height, 1, {});
        double mean = 0;
        for (int i = 0; i < width * height; ++i) {
            image.bytes.push_back(static_cast<uint8_t>(generator()));
            mean += image.bytes.back() / 255.0 / (width * height);
        }
        // The last level is one texel, whose value is the mean to the rounding of each level.
        const TextureImage t(image, false, true);
        const Vec4 last = sample(t, sampler(Wrap::repeat), {0.3f, 0.8f}, 1000);
        EXPECT_NEAR(static_cast<double>(last.x), mean, 2.0 / 255) << width << "x" << height;
    }
}

TEST(Texture, ChoosesTheLevelByTheFootprint) {
    // A checkerboard of single texels: grey from level 1 on, half contrast halfway there.
    Image image = byte_image(64, 64, 1, {});
    for (int i = 0; i < 64 * 64; ++i) {
        image.bytes.push_back((i + i / 64) % 2 ? 255 : 0);
    }
    const TextureImage t(image, false, true);
    const Vec2 on_texel(1.5f / 64, 0.5f / 64);
    const auto at = [&](Filter min, float texels) {
        return sample(t, sampler(Wrap::repeat, Filter::linear, min), on_texel, texels / 64).x;
    };
    const Filter trilinear = Filter::linear_mipmap_linear;
    EXPECT_NEAR(at(trilinear, 0.5f), 1, 1e-5f);
    EXPECT_NEAR(at(trilinear, 1.0f), 1, 1e-5f);
    EXPECT_NEAR(at(trilinear, std::sqrt(2.0f)), 0.75f, 0.01f);
    EXPECT_NEAR(at(trilinear, 2.0f), 0.5f, 0.003f);
    EXPECT_NEAR(at(trilinear, 1e6f), 0.5f, 0.01f);
    EXPECT_NEAR(at(Filter::linear_mipmap_nearest, 1.3f), 1, 1e-5f);
    EXPECT_NEAR(at(Filter::nearest_mipmap_nearest, 1.6f), 0.5f, 0.003f);
    EXPECT_NEAR(at(Filter::nearest, 8.0f), 1, 1e-5f);
    EXPECT_NEAR(at(Filter::linear, 8.0f), 1, 1e-5f);
}

/// 64 × 64 texels of one channel.
Image square(const std::function<bool(int, int)>& is_white) {
    Image image = byte_image(64, 64, 1, {});
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) image.bytes.push_back(is_white(x, y) ? 255 : 0);
    return image;
}

TEST(Texture, ALongFootprintBlursAlongItselfOnly) {
    const Image columns_image = square([](int x, int) { return x % 2 == 1; });
    const TextureImage columns(columns_image, false, true);
    const Texture t = sampler(Wrap::repeat);
    const Vec2 on_white(1.5f / 64, 0.5f / 64), on_black(2.5f / 64, 0.5f / 64);
    for (const float length : {3.0f, 5.5f, 8.0f}) {
        const TextureFootprint down = footprint({0, length / 64}, 1.0f / 64);
        EXPECT_NEAR(sample(columns, t, on_white, down).x, 1, 1e-5f);
        EXPECT_NEAR(sample(columns, t, on_black, down).x, 0, 1e-5f);
        // Probes 1.25 texels apart cancel out in pairs: at most one of them is left over.
        const TextureFootprint right = footprint({length / 64, 0}, 1.0f / 64);
        const float probes = std::round(length / 1.25f);
        EXPECT_NEAR(sample(columns, t, on_white, right).x, 0.5f, 0.5f / probes + 1e-5f);
    }
}

TEST(Texture, ATurnedFootprintFollowsDiagonals) {
    const Image stripes_image = square([](int x, int y) { return (x + y) % 8 < 4; });
    const TextureImage stripes(stripes_image, false, true);
    const Texture t = sampler(Wrap::repeat);
    const Vec2 on_white(1.5f / 64, 0.5f / 64), on_black(5.5f / 64, 0.5f / 64);
    const TextureFootprint along = footprint({6.0f / 64, -6.0f / 64}, 1.0f / 64);
    EXPECT_GT(sample(stripes, t, on_white, along).x, 0.95f);
    EXPECT_LT(sample(stripes, t, on_black, along).x, 0.05f);
    const TextureFootprint across = footprint({4.0f / 64, 4.0f / 64}, 1.0f / 64);  // one period
    EXPECT_NEAR(sample(stripes, t, on_white, across).x, 0.5f, 0.1f);
    EXPECT_NEAR(sample(stripes, t, on_black, across).x, 0.5f, 0.1f);
}

TEST(Texture, ALongFootprintHasTheMeanOfItsTexels) {
    std::mt19937 generator(5);
    const Image noise_image = square([&](int, int) { return generator() % 2 == 0; });
    const TextureImage noise(noise_image, false, true);
    const auto red_at = [&](Vec2 uv, const TextureFootprint& f) {
        return static_cast<double>(sample(noise, sampler(Wrap::repeat), uv, f).x);
    };
    double sum = 0;
    for (int i = 0; i < 100; ++i) {
        const Vec2 uv(static_cast<float>(generator() % 6400) / 6400, 10.5f / 64);
        double mean = 0;  // over eight texels
        for (int k = 0; k < 800; ++k) {
            const float texels = (static_cast<float>(k) - 399.5f) / 100;
            mean += red_at(uv + Vec2(texels / 64, 0), {}) / 800;
        }
        const double error = red_at(uv, footprint({8.0f / 64, 0}, 1.0f / 64)) - mean;
        sum += error * error / 100;
    }
    // Six probes weigh each of eight texels by 1/9 to 1/6 instead of 1/8; texels deviate from their
    // mean by 1/2.
    EXPECT_LT(std::sqrt(sum), 0.5 * std::sqrt(8.0) / 24);
}

TEST(Texture, AFootprintLongerThanItsProbesReachIsBlurredInstead) {
    const Image columns_image = square([](int x, int) { return x % 2 == 1; });
    const TextureImage columns(columns_image, false, true);
    for (const float length : {20.0f, 50.0f, 1e6f}) {
        for (const float u : {1.5f / 64, 2.0f / 64, 2.5f / 64}) {
            const Vec4 v = sample(columns, sampler(Wrap::repeat), {u, 0.5f / 64},
                                  footprint({length / 64, 0}, 1.0f / 64));
            EXPECT_NEAR(v.x, 0.5f, 0.003f) << length;  // half in eight bits
        }
    }
}

TEST(Texture, TheFootprintIsMeasuredInTexelsOfBothAxes) {
    // Square in uv, but 64 texels wide and one high: stripes along u must not be blurred by v.
    Image wide = byte_image(64, 4, 1, {});
    for (int i = 0; i < 64 * 4; ++i) wide.bytes.push_back(i / 64 % 2 ? 255 : 0);
    const TextureImage t(wide, false, true);
    const float texel = 1 / 4.0f;
    EXPECT_NEAR(sample(t, sampler(Wrap::repeat), {0.3f, 1.5f / 4}, texel / 2).x, 1, 1e-5f);
}

TEST(Texture, ASamplerWithoutMipmapsReadsOneTexelOfALongFootprint) {
    const Image columns_image = square([](int x, int) { return x % 2 == 1; });
    const TextureImage columns(columns_image, false, true);
    for (const Filter min : {Filter::nearest, Filter::linear}) {
        const Vec4 v = sample(columns, sampler(Wrap::repeat, Filter::linear, min),
                              {1.5f / 64, 0.5f / 64}, footprint({8.0f / 64, 0}, 1.0f / 64));
        EXPECT_NEAR(v.x, 1, 1e-5f);
    }
}

TEST(Texture, ReadsFiniteColoursAtNanAndHugeCoordinates) {
    const Image t_image = byte_image(3, 5, 3, std::vector<uint8_t>(45, 51));
    const TextureImage t(t_image, false, true);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    for (const Wrap wrap : {Wrap::repeat, Wrap::clamp_to_edge, Wrap::mirrored_repeat}) {
        for (const Filter mag : {Filter::nearest, Filter::linear}) {
            for (const float u : {nan, inf, -inf, 1e30f, -1e30f, 16777217.0f, -1e-30f, -0.0f}) {
                for (const float footprint : {0.0f, 0.1f, 1e30f, inf, nan}) {
                    const Vec4 v = sample(t, sampler(wrap, mag), {u, -u}, footprint);
                    EXPECT_NEAR(v.x, 0.2f, 1e-5f);
                }
            }
        }
    }
}

TEST(Texture, AppliesKhrTextureTransform) {
    TextureRef ref;
    ref.offset = {0.5f, 0.25f};
    ref.scale = {2, 3};
    EXPECT_EQ(transform_uv(ref, {1, 1}), Vec2(2.5f, 3.25f));
    ref.rotation = pi / 2;  // counter-clockwise on screen, since v points down
    const Vec2 turned = transform_uv(ref, {1, 0});
    EXPECT_NEAR(turned.x, 0.5f, 1e-6f);
    EXPECT_NEAR(turned.y, 0.25f - 2, 1e-6f);
}

}  // namespace
}  // namespace sightline
