#pragma once
// JPEG by libjpeg-turbo.
#include "image/image.h"

#include <vector>

namespace sightline {

/// Decodes a JPEG: grey, or RGB, to which YCbCr and (inverted, as Adobe writes it) CMYK are
/// converted. A missing end is passed over and named in Image::damage. Throws Error on other
/// damage and beyond the limits. `wanted`: see decode_image.
Image decode_jpeg(std::span<const std::byte> file, const std::string& name,
                  const ImageLimits& limits, const WantedLevel& wanted);

/// Encodes 8-bit grey or RGB pixels with quality 95 and colours at full resolution. Throws Error if
/// a side is longer than JPEG's 65500 pixels; `name` is the image's, for messages.
std::vector<std::byte> encode_jpeg(const Image& image, const std::string& name);

}  // namespace sightline
