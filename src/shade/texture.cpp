#include "shade/texture.h"

#include "core/srgb.h"
#include "shade/fast_math.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace sightline {
namespace {

/// Four floats that the compiler keeps in one register.
using Float4 = float __attribute__((vector_size(16)));

/// Values of bytes as floats in [0,1], linear and decoded from sRGB.
struct ByteTables {
    std::array<float, 256> linear, srgb;
    ByteTables() {
        for (size_t i = 0; i < 256; ++i) {
            linear[i] = static_cast<float>(i) / 255.0f;
            srgb[i] = decode_srgb(linear[i]);
        }
    }
};
const ByteTables byte_tables;

/// Reads texels of `Channels` interleaved values. Grey is copied to RGB; missing alpha is 1.
template <class T, int Channels>
struct Texels {
    const T* data;
    int width;
    const float* rgb_table;

    float color(T v) const {
        if constexpr (sizeof(T) == 1)
            return rgb_table[v];
        else
            return v;
    }
    static float alpha(T v) {
        if constexpr (sizeof(T) == 1)
            return byte_tables.linear[v];
        else
            return v;
    }
    Float4 at(int x, int y) const {
        const T* p =
            data + (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) *
                       Channels;
        if constexpr (Channels >= 3) {
            return Float4{color(p[0]), color(p[1]), color(p[2]), Channels == 4 ? alpha(p[3]) : 1};
        } else {
            const float grey = color(p[0]);
            return Float4{grey, grey, grey, Channels == 2 ? alpha(p[1]) : 1};
        }
    }
};

/// Wraps a coordinate into [0,1]. NaN and magnitudes of 2²² and more become 0.
float wrapped(Wrap wrap, float u) {
    if (!(std::fabs(u) < 4194304.0f)) return 0;
    if (wrap == Wrap::clamp_to_edge) return std::min(std::max(u, 0.0f), 1.0f);
    const int i = floor_to_int(u);
    const float f = u - static_cast<float>(i);
    return wrap == Wrap::mirrored_repeat && (i & 1) ? 1 - f : f;
}

using Taps = TextureLookup::Taps;

/// `u` in [0,1]. Beyond the border continues the other end if the image repeats, otherwise (clamped
/// or mirrored) the border texel.
Taps taps(float u, int size, Wrap wrap) {
    const float x = u * static_cast<float>(size) - 0.5f;
    const int first = floor_to_int(x);
    Taps t{first, first + 1, x - static_cast<float>(first)};
    const bool repeats = wrap == Wrap::repeat;
    if (t.first < 0) t.first = repeats ? size - 1 : 0;
    if (t.second >= size) t.second = repeats ? 0 : size - 1;
    return t;
}

template <class T, int Channels>
Float4 bilinear(const Texels<T, Channels>& texels, const Taps& x, const Taps& y) {
    const Float4 a = texels.at(x.first, y.first), b = texels.at(x.second, y.first);
    const Float4 c = texels.at(x.first, y.second), d = texels.at(x.second, y.second);
    const Float4 top = a + (b - a) * x.fraction, bottom = c + (d - c) * x.fraction;
    return top + (bottom - top) * y.fraction;
}

Taps nearest(float u, int size) {
    const int texel = std::min(static_cast<int>(u * static_cast<float>(size)), size - 1);
    return {texel, texel, 0};
}

struct Mip {
    size_t level = 0;
    float blend = 0;     ///< towards the next level
    bool linear = true;  ///< interpolates texels
};

/// `texels`: width of the sample in texels of the first level.
Mip choose_mip(const Texture& sampler, float texels, size_t levels) {
    if (!(texels > 1)) return {0, 0, sampler.mag != Filter::nearest};
    const Filter min = sampler.min;
    const bool linear = min == Filter::linear || min == Filter::linear_mipmap_nearest ||
                        min == Filter::linear_mipmap_linear;
    if (min == Filter::nearest || min == Filter::linear || levels == 1) return {0, 0, linear};
    const float lod = std::min(fast_log2(std::min(texels, 1e9f)), static_cast<float>(levels - 1));
    if (min == Filter::nearest_mipmap_nearest || min == Filter::linear_mipmap_nearest)
        return {static_cast<size_t>(lod + 0.5f), 0, linear};
    const auto fine = static_cast<size_t>(lod);
    return {fine, lod - static_cast<float>(fine), linear};
}

// The texels of the finer level that one texel of the coarser covers along one axis, and their
// weights: two whole ones if the size is even, up to three otherwise.
struct Cover {
    int first = 0, count = 0;
    float weights[3] = {0, 0, 0};
};

std::vector<Cover> covers(int fine, int coarse) {
    std::vector<Cover> result(static_cast<size_t>(coarse));
    const double ratio = static_cast<double>(fine) / coarse;
    for (int i = 0; i < coarse; ++i) {
        Cover& cover = result[static_cast<size_t>(i)];
        const double low = i * ratio, high = (i + 1) * ratio;
        cover.first = static_cast<int>(low);
        while (cover.count < 3 && cover.first + cover.count < fine) {
            const int texel = cover.first + cover.count;
            const double part = std::min(high, texel + 1.0) - std::max(low, texel + 0.0);
            if (part <= 1e-9) break;
            cover.weights[cover.count++] = static_cast<float>(part / ratio);
        }
    }
    return result;
}

/// Bytes to linear 16-bit values and back; `srgb`: the bytes are sRGB-encoded.
struct ByteCodec {
    std::array<uint32_t, 256> decode;
    std::array<uint8_t, 16384> encode;  // of the upper 14 bits
    explicit ByteCodec(bool srgb) {
        for (size_t i = 0; i < 256; ++i) {
            const float v = srgb ? byte_tables.srgb[i] : byte_tables.linear[i];
            decode[i] = static_cast<uint32_t>(v * 65535.0f + 0.5f);
        }
        for (size_t i = 0; i < encode.size(); ++i) {
            const float v = (static_cast<float>(i) + 0.5f) / static_cast<float>(encode.size());
            encode[i] = static_cast<uint8_t>((srgb ? encode_srgb(v) : v) * 255.0f + 0.5f);
        }
    }
};

const ByteCodec& codec(bool srgb) {
    static const ByteCodec linear(false), encoded(true);
    return srgb ? encoded : linear;
}

bool is_alpha(int channel, int channels) { return channels % 2 == 0 && channel == channels - 1; }

/// Means of 2×2 texels, for even sizes, which are usual.
void halve_bytes(const uint8_t* fine, int width, int channels, bool srgb, uint8_t* coarse,
                 int coarse_width, int coarse_height) {
    std::array<const ByteCodec*, 4> codecs{};
    for (int c = 0; c < channels; ++c) {
        codecs[static_cast<size_t>(c)] = &codec(srgb && !is_alpha(c, channels));
    }
    const ptrdiff_t row = static_cast<ptrdiff_t>(width) * channels;
    for (int y = 0; y < coarse_height; ++y) {
        const uint8_t* p = fine + 2 * y * row;
        for (int x = 0; x < coarse_width; ++x, p += 2 * channels) {
            for (int c = 0; c < channels; ++c) {
                const ByteCodec& k = *codecs[static_cast<size_t>(c)];
                const uint32_t sum = k.decode[p[c]] + k.decode[p[c + channels]] +
                                     k.decode[p[c + row]] + k.decode[p[c + row + channels]];
                *coarse++ = k.encode[sum >> 4];
            }
        }
    }
}

/// Means over exact areas, for any size. `decode` and `encode` take a channel and a value.
template <class T, class Decode, class Encode>
void shrink(const T* fine, int width, int height, int channels, T* coarse, int coarse_width,
            int coarse_height, Decode decode, Encode encode) {
    const std::vector<Cover> columns = covers(width, coarse_width);
    const std::vector<Cover> rows = covers(height, coarse_height);
    for (const Cover& row : rows) {
        for (const Cover& column : columns) {
            for (int c = 0; c < channels; ++c) {
                float sum = 0;
                for (int j = 0; j < row.count; ++j) {
                    for (int i = 0; i < column.count; ++i) {
                        const ptrdiff_t at =
                            (static_cast<ptrdiff_t>(row.first + j) * width + column.first + i) *
                                channels +
                            c;
                        sum += row.weights[j] * column.weights[i] * decode(c, fine[at]);
                    }
                }
                *coarse++ = encode(c, sum);
            }
        }
    }
}

}  // namespace

TextureImage::TextureImage(const Image& image, bool srgb, bool mipmaps)
    : channels_(image.channels),
      srgb_(srgb),
      texels_per_uv_(
          std::sqrt(static_cast<float>(image.width) * static_cast<float>(image.height))) {
    assert(!image.empty() && channels_ >= 1 && channels_ <= 4);
    const float* floats = image.bytes.empty() ? image.floats.data() : nullptr;
    levels_.push_back({image.width, image.height, floats ? nullptr : image.bytes.data(), floats});
    size_t values = floats && srgb ? image.floats.size() : 0;
    if (mipmaps) {
        for (int w = image.width, h = image.height; w > 1 || h > 1;) {
            w = std::max(1, w / 2);
            h = std::max(1, h / 2);
            levels_.push_back({w, h, nullptr, nullptr});
            values +=
                static_cast<size_t>(w) * static_cast<size_t>(h) * static_cast<size_t>(channels_);
        }
    }
    if (floats) {
        float_storage_.resize(values);
    } else {
        byte_storage_.resize(values);
    }
    if (floats && srgb) {
        for (size_t i = 0; i < image.floats.size(); ++i) {
            const int c = static_cast<int>(i % static_cast<size_t>(channels_));
            float_storage_[i] = is_alpha(c, channels_) ? floats[i] : decode_srgb(floats[i]);
        }
        levels_[0].floats = float_storage_.data();
    }
    build_pyramid();
}

void TextureImage::build_pyramid() {
    uint8_t* bytes = byte_storage_.data();
    float* floats = float_storage_.data();
    const auto values = [&](const Level& level) {
        return static_cast<ptrdiff_t>(level.width) * level.height * channels_;
    };
    if (levels_[0].floats == floats && floats) floats += values(levels_[0]);
    for (size_t i = 1; i < levels_.size(); ++i) {
        const Level& fine = levels_[i - 1];
        Level& coarse = levels_[i];
        if (fine.floats) {
            build_float_level(fine, coarse, floats);
            coarse.floats = floats;
            floats += values(coarse);
        } else {
            build_byte_level(fine, coarse, bytes);
            coarse.bytes = bytes;
            bytes += values(coarse);
        }
    }
}

void TextureImage::build_byte_level(const Level& fine, const Level& coarse, uint8_t* bytes) const {
    if (fine.width % 2 == 0 && fine.height % 2 == 0)
        return halve_bytes(fine.bytes, fine.width, channels_, srgb_, bytes, coarse.width,
                           coarse.height);
    const auto to_linear = [&](int c, uint8_t v) {
        return srgb_ && !is_alpha(c, channels_) ? byte_tables.srgb[v] : byte_tables.linear[v];
    };
    const auto to_byte = [&](int c, float v) {
        const auto i = static_cast<size_t>(std::min(v, 1.0f) * 16383.99f);
        return codec(srgb_ && !is_alpha(c, channels_)).encode[i];
    };
    shrink(fine.bytes, fine.width, fine.height, channels_, bytes, coarse.width, coarse.height,
           to_linear, to_byte);
}

void TextureImage::build_float_level(const Level& fine, const Level& coarse, float* floats) const {
    const auto same = [](int, float v) { return v; };
    shrink(fine.floats, fine.width, fine.height, channels_, floats, coarse.width, coarse.height,
           same, same);
}

TextureLookup::Level TextureImage::locate(const Texture& sampler, size_t level, bool linear,
                                          Vec2 uv) const {
    const auto [width, height, bytes, floats] = levels_[level];
    if (!linear) return {level, nearest(uv.x, width), nearest(uv.y, height)};
    return {level, taps(uv.x, width, sampler.wrap_s), taps(uv.y, height, sampler.wrap_t)};
}

TextureLookup TextureImage::locate(const Texture& sampler, Vec2 uv, float footprint) const {
    const Vec2 at(wrapped(sampler.wrap_s, uv.x), wrapped(sampler.wrap_t, uv.y));
    const Mip mip = choose_mip(sampler, footprint * texels_per_uv_, levels_.size());
    TextureLookup lookup;
    lookup.fine = locate(sampler, mip.level, mip.linear, at);
    lookup.blend = mip.blend;
    if (mip.blend > 0) lookup.coarse = locate(sampler, mip.level + 1, mip.linear, at);
    return lookup;
}

Vec4 TextureImage::read(const TextureLookup::Level& lookup) const {
    const Level& level = levels_[lookup.index];
    const auto from = [&](const auto& texels) {
        const Float4 value = bilinear(texels, lookup.x, lookup.y);
        return Vec4(value[0], value[1], value[2], value[3]);
    };
    const float* table = srgb_ ? byte_tables.srgb.data() : byte_tables.linear.data();
    if (level.bytes) {
        switch (channels_) {
            case 1:
                return from(Texels<uint8_t, 1>{level.bytes, level.width, table});
            case 2:
                return from(Texels<uint8_t, 2>{level.bytes, level.width, table});
            case 3:
                return from(Texels<uint8_t, 3>{level.bytes, level.width, table});
            default:
                return from(Texels<uint8_t, 4>{level.bytes, level.width, table});
        }
    }
    switch (channels_) {
        case 1:
            return from(Texels<float, 1>{level.floats, level.width, nullptr});
        case 2:
            return from(Texels<float, 2>{level.floats, level.width, nullptr});
        case 3:
            return from(Texels<float, 3>{level.floats, level.width, nullptr});
        default:
            return from(Texels<float, 4>{level.floats, level.width, nullptr});
    }
}

Vec4 TextureImage::read(const TextureLookup& lookup) const {
    const Vec4 value = read(lookup.fine);
    return lookup.blend > 0 ? value + (read(lookup.coarse) - value) * lookup.blend : value;
}

size_t TextureImage::memory() const {
    return byte_storage_.size() + float_storage_.size() * sizeof(float);
}

Vec2 transform_uv(const TextureRef& ref, Vec2 uv) {
    const float c = std::cos(ref.rotation), s = std::sin(ref.rotation);
    const Vec2 scaled(uv.x * ref.scale.x, uv.y * ref.scale.y);
    return {c * scaled.x + s * scaled.y + ref.offset.x,
            -s * scaled.x + c * scaled.y + ref.offset.y};
}

}  // namespace sightline
