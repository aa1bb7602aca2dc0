#pragma once
// What the targets of image decoders share.
#include "core/error.h"
#include "image/image.h"

#include <cstdlib>
#include <string_view>

namespace sightline {

/// Decodes the input whole and at the level that its last byte names. Aborts if a decoder returns
/// other than the pixels of its size, or throws a message of more than one line.
template <class Decode>
void decode_input(const uint8_t* data, size_t size, Decode decode) {
    const std::span<const std::byte> file(reinterpret_cast<const std::byte*>(data), size);
    const uint8_t last = size > 0 ? data[size - 1] : 0;
    const WantedLevel coarse{last & 7, (last & 8) != 0};
    for (const WantedLevel& wanted : {WantedLevel{}, coarse}) {
        try {
            const Image image = decode(file, "input", ImageLimits{.max_pixels = 1 << 18}, wanted);
            const size_t values = static_cast<size_t>(image.width) *
                                  static_cast<size_t>(image.height) *
                                  static_cast<size_t>(image.channels);
            if (image.bytes.size() + image.floats.size() != values) std::abort();
        } catch (const Error& error) {
            if (std::string_view(error.what()).find('\n') != std::string_view::npos) std::abort();
        }
    }
}

}  // namespace sightline
