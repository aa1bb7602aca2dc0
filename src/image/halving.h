#pragma once
// Coarser levels of an image's pyramid: means of 2 × 2 pixels in linear light.
#include "image/image.h"

#include <array>

namespace sightline {

/// Bytes to linear values, and means of those back to bytes.
struct ByteCodec {
    std::array<float, 256> values;      ///< in [0,1]
    std::array<uint32_t, 256> decode;   ///< the same times 65535, rounded
    std::array<uint8_t, 16384> encode;  ///< of the upper 14 bits of a 16-bit value
    explicit ByteCodec(bool srgb);
};

/// The codec of linear bytes or of sRGB-encoded ones.
const ByteCodec& byte_codec(bool srgb);

/// Whether the channel with this index is alpha, which is never sRGB-encoded.
constexpr bool is_alpha(int channel, int channels) {
    return channels % 2 == 0 && channel == channels - 1;
}

/// Means of 2 × 2 pixels from two rows, `coarse_width` of them. `srgb`: colours are sRGB-encoded.
void halve_rows(const uint8_t* upper, const uint8_t* lower, int coarse_width, int channels,
                bool srgb, uint8_t* coarse);

/// The level of a pyramid, at most `wanted`, whose pixels are means of 2 × 2 of the level before
/// all the way: sizes that a power of two divides.
int exact_level(int width, int height, int wanted);

/// Takes the rows of an 8-bit image from the top and keeps a level of its pyramid alone, without
/// ever holding a finer one. Its members throw nothing once it is constructed.
class RowHalver {
  public:
    /// `image` has the size and the channels of the rows; it gets the size of the level and its
    /// bytes. `halvings` is at most exact_level of the size.
    RowHalver(Image& image, int halvings, bool srgb);
    RowHalver(const RowHalver&) = delete;

    /// Where the bytes of the next row go, before finish_row.
    uint8_t* row() { return row_of(0); }
    void finish_row();

  private:
    /// Rows of one level: its last two, or all of them if it is kept.
    struct Level {
        size_t row_bytes;
        size_t rows;  ///< finished
        std::vector<uint8_t> pair;
    };
    uint8_t* row_of(size_t level);

    Image& image_;
    bool srgb_;
    std::vector<Level> levels_;
};

/// Replaces an 8-bit image by a level of its pyramid, at most `wanted.level`: exact_level.
void keep_level(Image& image, const WantedLevel& wanted);

}  // namespace sightline
