#pragma once
// The sRGB transfer function (IEC 61966-2-1) for values from 0 to 1.
#include <cmath>

namespace sightline {

/// The linear value of an encoded one.
inline float decode_srgb(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

/// The encoded value of a linear one, clamped to 0…1; NaN becomes 0.
inline float encode_srgb(float light) {
    if (!(light > 0)) return 0;
    if (light >= 1) return 1;
    return light <= 0.0031308f ? 12.92f * light : 1.055f * std::pow(light, 1 / 2.4f) - 0.055f;
}

}  // namespace sightline
