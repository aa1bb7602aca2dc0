#include "shade/texture.h"

#include "core/srgb.h"
#include "image/halving.h"
#include "shade/fast_math.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <tuple>

namespace sightline {
namespace {

/// Four floats that the compiler keeps in one register.
using Float4 = float __attribute__((vector_size(16)));

// Here, because the guard of the function's variable would be checked at every lookup.
const ByteCodec& linear_codec = byte_codec(false);
const ByteCodec& srgb_codec = byte_codec(true);

/// Reads texels of `Channels` interleaved values. Grey is copied to RGB; missing alpha is 1.
template <class T, int Channels>
struct Texels {
    const T* data;
    int width;
    const float *rgb_table, *alpha_table;

    float color(T v) const {
        if constexpr (sizeof(T) == 1)
            return rgb_table[v];
        else
            return v;
    }
    float alpha(T v) const {
        if constexpr (sizeof(T) == 1)
            return alpha_table[v];
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
    if (u >= 0 && u < 1) return u;
    if (!(std::fabs(u) < 4194304.0f)) return 0;
    if (wrap == Wrap::clamp_to_edge) return std::min(std::max(u, 0.0f), 1.0f);
    const int i = floor_to_int(u);
    const float f = u - static_cast<float>(i);
    return wrap == Wrap::mirrored_repeat && (i & 1) ? 1 - f : f;
}

using Taps = TextureLookup::Taps;

/// `u` in [0,1]. Beyond the border continues the other end if the image repeats, otherwise (clamped
/// or mirrored) the border texel.
void set_taps(Taps& taps, float u, int size, Wrap wrap) {
    const float x = u * static_cast<float>(size) - 0.5f;
    const int first = floor_to_int(x), second = first + 1;
    const bool repeats = wrap == Wrap::repeat;
    taps.first = first >= 0 ? first : repeats ? size - 1 : 0;
    taps.second = second < size ? second : repeats ? 0 : size - 1;
    taps.fraction = x - static_cast<float>(first);
}

void set_nearest(Taps& taps, float u, int size) {
    taps.first = taps.second = std::min(static_cast<int>(u * static_cast<float>(size)), size - 1);
    taps.fraction = 0;
}

template <class T, int Channels>
Float4 bilinear(const Texels<T, Channels>& texels, const Taps& x, const Taps& y) {
    const Float4 a = texels.at(x.first, y.first), b = texels.at(x.second, y.first);
    const Float4 c = texels.at(x.first, y.second), d = texels.at(x.second, y.second);
    const Float4 top = a + (b - a) * x.fraction, bottom = c + (d - c) * x.fraction;
    return top + (bottom - top) * y.fraction;
}

bool has_mipmaps(Filter min) { return min != Filter::nearest && min != Filter::linear; }

/// How a lookup covers its footprint: by probes in a row, each with the filter of a mip level.
struct ProbeRow {
    uint32_t count = 1;
    float lod = 0;    ///< log₂ of the width in texels that a probe covers; 0 if that is below 1
    Vec2 axis{0, 0};  ///< along the whole row, in texels
};

/// Distance between probes over their width. Bilinear interpolation reaches a texel to both sides,
/// so that texels which are black and white in turns still come out grey.
constexpr float probe_spacing = 1.25f;

/// The probes for a footprint of `texels`. There is more than one if `several` and if the longer
/// axis is at least twice the shorter one and two texels, below which interpolation blurs anyway
/// (McCormack et al. 1999, "Feline: Fast Elliptical Lines for Anisotropic Texture Mapping").
ProbeRow probe_row(const TextureFootprint& texels, bool several) {
    const float mean = 0.5f * (texels.uu + texels.vv), half = 0.5f * (texels.uu - texels.vv);
    if (!(2 * mean > 1)) return {};
    const float root = std::sqrt(half * half + texels.uv * texels.uv);
    const float major2 = mean + root, minor2 = std::max(mean - root, 0.0f);
    const float width2 = std::max(minor2, 1.0f);
    if (!several || !(major2 > 4 * width2)) {
        const float width4 = major2 * minor2;  // of the round footprint with the same area
        return {1, width4 > 1 ? 0.25f * fast_log2(width4) : 0, {0, 0}};
    }
    ProbeRow row;
    // Rounds the ratio of the axes over the spacing.
    float reach = probe_spacing * 2;
    for (row.count = 2; row.count < TextureLookup::max_probes; ++row.count) {
        const float next = reach + 0.5f * probe_spacing;
        if (!(major2 > next * next * width2)) break;
        reach += probe_spacing;
    }
    row.lod = 0.5f * fast_log2(std::max(width2, major2 / (reach * reach)));
    row.axis = half >= 0 ? Vec2(half + root, texels.uv) : Vec2(texels.uv, root - half);
    row.axis *= std::sqrt(major2 / row.axis.length2());
    return row;
}

struct Mip {
    uint32_t level = 0;
    float blend = 0;     ///< towards the next level
    bool linear = true;  ///< interpolates texels
};

/// `lod` is log₂ of the width in texels of the first level.
Mip choose_mip(const Texture& sampler, float lod, size_t levels) {
    if (!(lod > 0)) return {0, 0, sampler.mag != Filter::nearest};
    const Filter min = sampler.min;
    const bool linear = min == Filter::linear || min == Filter::linear_mipmap_nearest ||
                        min == Filter::linear_mipmap_linear;
    if (!has_mipmaps(min) || levels == 1) return {0, 0, linear};
    lod = std::min(lod, static_cast<float>(levels - 1));
    if (min == Filter::nearest_mipmap_nearest || min == Filter::linear_mipmap_nearest)
        return {static_cast<uint32_t>(lod + 0.5f), 0, linear};
    const auto fine = static_cast<uint32_t>(lod);
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
    : channels_(image.channels), finest_(static_cast<uint32_t>(image.level)), srgb_(srgb) {
    assert(!image.empty() && channels_ >= 1 && channels_ <= 4);
    const float* floats = image.bytes.empty() ? image.floats.data() : nullptr;
    for (int finer = image.level; finer > 0; --finer)
        levels_.push_back({image.width << finer, image.height << finer, nullptr, nullptr});
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
        levels_[finest_].floats = float_storage_.data();
    }
    build_pyramid();
}

void TextureImage::build_pyramid() {
    uint8_t* bytes = byte_storage_.data();
    float* floats = float_storage_.data();
    const auto values = [&](const Level& level) {
        return static_cast<ptrdiff_t>(level.width) * level.height * channels_;
    };
    if (levels_[finest_].floats == floats && floats) floats += values(levels_[finest_]);
    for (size_t i = finest_ + 1; i < levels_.size(); ++i) {
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
    if (fine.width % 2 == 0 && fine.height % 2 == 0) {
        const ptrdiff_t fine_row = static_cast<ptrdiff_t>(fine.width) * channels_;
        const ptrdiff_t coarse_row = static_cast<ptrdiff_t>(coarse.width) * channels_;
        for (int y = 0; y < coarse.height; ++y) {
            const uint8_t* upper = fine.bytes + 2 * y * fine_row;
            halve_rows(upper, upper + fine_row, coarse.width, channels_, srgb_,
                       bytes + y * coarse_row);
        }
        return;
    }
    const auto to_linear = [&](int c, uint8_t v) {
        return byte_codec(srgb_ && !is_alpha(c, channels_)).values[v];
    };
    const auto to_byte = [&](int c, float v) {
        const auto i = static_cast<size_t>(std::min(v, 1.0f) * 16383.99f);
        return byte_codec(srgb_ && !is_alpha(c, channels_)).encode[i];
    };
    shrink(fine.bytes, fine.width, fine.height, channels_, bytes, coarse.width, coarse.height,
           to_linear, to_byte);
}

void TextureImage::build_float_level(const Level& fine, const Level& coarse, float* floats) const {
    const auto same = [](int, float v) { return v; };
    shrink(fine.floats, fine.width, fine.height, channels_, floats, coarse.width, coarse.height,
           same, same);
}

void TextureImage::place(TextureLookup::Probe& probe, const Texture& sampler, bool linear,
                         Vec2 uv) const {
    const int width = levels_[probe.level].width, height = levels_[probe.level].height;
    const float u = wrapped(sampler.wrap_s, uv.x), v = wrapped(sampler.wrap_t, uv.y);
    if (linear) {
        set_taps(probe.x, u, width, sampler.wrap_s);
        set_taps(probe.y, v, height, sampler.wrap_t);
    } else {
        set_nearest(probe.x, u, width);
        set_nearest(probe.y, v, height);
    }
}

void TextureImage::locate(const Texture& sampler, Vec2 uv, const TextureFootprint& footprint,
                          TextureLookup& lookup) const {
    const auto width = static_cast<float>(levels_[0].width);
    const auto height = static_cast<float>(levels_[0].height);
    constexpr float largest = 1e18f;  // its square is finite
    const ProbeRow row = probe_row({std::min(footprint.uu * width * width, largest),
                                    std::clamp(footprint.uv * width * height, -largest, largest),
                                    std::min(footprint.vv * height * height, largest)},
                                   has_mipmaps(sampler.min));
    Mip mip = choose_mip(sampler, row.lod, levels_.size());
    if (mip.level < finest_) {
        if (footprint.uu + footprint.vv > 0) finer_lookups_.fetch_add(1, std::memory_order_relaxed);
        mip = {finest_, 0, mip.linear};
    }
    if (row.count == 1) {
        lookup.count = mip.blend > 0 ? 2 : 1;
        for (uint32_t i = 0; i < lookup.count; ++i) {
            TextureLookup::Probe& probe = lookup.probes[i];
            probe.level = mip.level + i;
            probe.weight = i == 0 ? 1 - mip.blend : mip.blend;
            place(probe, sampler, mip.linear, uv);
        }
        return;
    }
    // The share of probes that read the next level is the blend, so that none reads both. They are
    // spread over the row by multiples of the golden ratio.
    static constexpr float thresholds[TextureLookup::max_probes] = {0.309f, 0.927f, 0.545f, 0.163f,
                                                                    0.781f, 0.399f, 0.017f, 0.635f};
    const Vec2 axis(row.axis.x / width, row.axis.y / height);
    const float weight = 1 / static_cast<float>(row.count);
    lookup.count = row.count;
    for (uint32_t i = 0; i < lookup.count; ++i) {
        TextureLookup::Probe& probe = lookup.probes[i];
        probe.level = mip.level + (mip.blend > thresholds[i] ? 1 : 0);
        probe.weight = weight;
        place(probe, sampler, mip.linear,
              uv + axis * ((static_cast<float>(i) + 0.5f) * weight - 0.5f));
    }
}

template <class T, int Channels>
Vec4 TextureImage::read(const TextureLookup& lookup) const {
    const float* colors = (srgb_ ? srgb_codec : linear_codec).values.data();
    const float* alphas = linear_codec.values.data();
    Float4 sum = {0, 0, 0, 0};
    for (uint32_t i = 0; i < lookup.count; ++i) {
        const TextureLookup::Probe& probe = lookup.probes[i];
        const Level& level = levels_[probe.level];
        const Texels<T, Channels> texels = {
            std::get<const T*>(std::tuple(level.bytes, level.floats)), level.width, colors, alphas};
        sum += bilinear(texels, probe.x, probe.y) * probe.weight;
    }
    return {sum[0], sum[1], sum[2], sum[3]};
}

Vec4 TextureImage::read(const TextureLookup& lookup) const {
    if (levels_[finest_].bytes) {
        switch (channels_) {
            case 1:
                return read<uint8_t, 1>(lookup);
            case 2:
                return read<uint8_t, 2>(lookup);
            case 3:
                return read<uint8_t, 3>(lookup);
            default:
                return read<uint8_t, 4>(lookup);
        }
    }
    switch (channels_) {
        case 1:
            return read<float, 1>(lookup);
        case 2:
            return read<float, 2>(lookup);
        case 3:
            return read<float, 3>(lookup);
        default:
            return read<float, 4>(lookup);
    }
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
