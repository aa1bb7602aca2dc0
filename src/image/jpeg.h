#pragma once
// JPEG by libjpeg-turbo.
#include "image/image.h"

namespace sightline {

/// Decodes a JPEG: grey, or RGB, to which YCbCr and (inverted, as Adobe writes it) CMYK are
/// converted. A missing end is passed over and named in Image::damage. Throws Error on other
/// damage and beyond the limits.
Image decode_jpeg(std::span<const std::byte> file, const std::string& name,
                  const ImageLimits& limits);

}  // namespace sightline
