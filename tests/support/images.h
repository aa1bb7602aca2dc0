#pragma once
#include "image/image.h"

namespace sightline {

/// An 8-bit image whose values vary from pixel to pixel.
inline Image pattern(int width, int height, int channels) {
    Image image;
    image.width = width;
    image.height = height;
    image.channels = channels;
    const auto values = static_cast<size_t>(width * height * channels);
    for (size_t i = 0; i < values; ++i) image.bytes.push_back(uint8_t(i * 37 + i / 7 * 11));
    return image;
}

}  // namespace sightline
