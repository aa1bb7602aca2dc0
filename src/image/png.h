#pragma once
// PNG by libpng, of which only the chunks that make pixels are read.
#include "image/image.h"

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

}  // namespace sightline
