#pragma once
// PNG by libpng, of which only the chunks that make pixels are read.
#include "image/image.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace sightline {

/// Decodes a PNG: palettes and colour keys become RGB and alpha, fewer than 8 bits become 8, 16
/// become floats. Nothing behind the last pixel is inflated, and no ancillary chunk but tRNS is
/// decoded. Damage that costs no pixel is passed over and named in Image::damage: a missing end, a
/// wrong checksum of an ancillary chunk. Throws Error on other damage and beyond the limits.
/// `wanted`: see decode_image.
Image decode_png(std::span<const std::byte> file, const std::string& name,
                 const ImageLimits& limits, const WantedLevel& wanted);

/// Encodes 8-bit pixels, marked as sRGB. The file's bytes depend on nothing else.
std::vector<std::byte> encode_png(const Image& image);

/// 16-bit values that are data and no colours.
struct DataImage {
    int width = 0, height = 0, channels = 1;  ///< 1 or 3
    std::vector<uint16_t> values;             ///< rows from the top, channels interleaved
    /// tEXt chunks: keywords of at most 79 Latin-1 characters, and their texts.
    std::vector<std::pair<std::string, std::string>> texts;
};

/// Encodes them, without a chunk that would make readers convert them.
std::vector<std::byte> encode_png(const DataImage& image);

}  // namespace sightline
