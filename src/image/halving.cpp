#include "image/halving.h"

#include "core/srgb.h"

#include <algorithm>
#include <utility>

namespace sightline {
namespace {

template <int Channels>
void halve(const uint8_t* upper, const uint8_t* lower, int coarse_width, bool srgb,
           uint8_t* coarse) {
    const ByteCodec& colors = byte_codec(srgb);
    const ByteCodec& alpha = byte_codec(false);
    for (int x = 0; x < coarse_width; ++x) {
        for (int c = 0; c < Channels; ++c) {
            const ByteCodec& k = is_alpha(c, Channels) ? alpha : colors;
            const uint32_t sum = k.decode[upper[c]] + k.decode[upper[c + Channels]] +
                                 k.decode[lower[c]] + k.decode[lower[c + Channels]];
            *coarse++ = k.encode[sum >> 4];
        }
        upper += 2 * Channels;
        lower += 2 * Channels;
    }
}

}  // namespace

ByteCodec::ByteCodec(bool srgb) {
    for (size_t i = 0; i < values.size(); ++i) {
        const float v = static_cast<float>(i) / 255.0f;
        values[i] = srgb ? decode_srgb(v) : v;
        decode[i] = static_cast<uint32_t>(values[i] * 65535.0f + 0.5f);
    }
    for (size_t i = 0; i < encode.size(); ++i) {
        const float v = (static_cast<float>(i) + 0.5f) / static_cast<float>(encode.size());
        encode[i] = static_cast<uint8_t>((srgb ? encode_srgb(v) : v) * 255.0f + 0.5f);
    }
}

const ByteCodec& byte_codec(bool srgb) {
    static const ByteCodec linear(false), encoded(true);
    return srgb ? encoded : linear;
}

void halve_rows(const uint8_t* upper, const uint8_t* lower, int coarse_width, int channels,
                bool srgb, uint8_t* coarse) {
    switch (channels) {
        case 1:
            return halve<1>(upper, lower, coarse_width, srgb, coarse);
        case 2:
            return halve<2>(upper, lower, coarse_width, srgb, coarse);
        case 3:
            return halve<3>(upper, lower, coarse_width, srgb, coarse);
        default:
            return halve<4>(upper, lower, coarse_width, srgb, coarse);
    }
}

int exact_level(int width, int height, int wanted) {
    if (width == 0 || height == 0) return 0;
    int level = 0;
    while (level < wanted && (width >> level) % 2 == 0 && (height >> level) % 2 == 0) ++level;
    return level;
}

RowHalver::RowHalver(Image& image, int halvings, bool srgb) : image_(image), srgb_(srgb) {
    const auto channels = static_cast<size_t>(image.channels);
    for (int k = 0; k <= halvings; ++k) {
        const size_t row_bytes = static_cast<size_t>(image.width >> k) * channels;
        levels_.push_back({row_bytes, 0, {}});
        if (k < halvings) levels_.back().pair.resize(2 * row_bytes);
    }
    image.width >>= halvings;
    image.height >>= halvings;
    image.level += halvings;
    image.bytes.resize(levels_.back().row_bytes * static_cast<size_t>(image.height));
}

uint8_t* RowHalver::row_of(size_t level) {
    Level& l = levels_[level];
    const bool is_kept = level + 1 == levels_.size();
    return is_kept ? &image_.bytes[l.rows * l.row_bytes] : &l.pair[l.rows % 2 * l.row_bytes];
}

void RowHalver::finish_row() {
    for (size_t k = 0; ++levels_[k].rows % 2 == 0 && k + 1 < levels_.size(); ++k) {
        const Level& fine = levels_[k];
        const auto coarse_width =
            static_cast<int>(fine.row_bytes / 2 / static_cast<size_t>(image_.channels));
        halve_rows(fine.pair.data(), fine.pair.data() + fine.row_bytes, coarse_width,
                   image_.channels, srgb_, row_of(k + 1));
    }
}

void keep_level(Image& image, const WantedLevel& wanted) {
    const int halvings = exact_level(image.width, image.height, wanted.level);
    if (halvings == 0 || image.bytes.empty()) return;
    const std::vector<uint8_t> fine = std::exchange(image.bytes, {});
    const size_t row_bytes = static_cast<size_t>(image.width) * static_cast<size_t>(image.channels);
    RowHalver rows(image, halvings, wanted.srgb);
    for (size_t at = 0; at < fine.size(); at += row_bytes) {
        std::copy_n(&fine[at], row_bytes, rows.row());
        rows.finish_row();
    }
}

}  // namespace sightline
