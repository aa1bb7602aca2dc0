#pragma once
// Fast approximations for shading, which does not need the last bits of libm. The same bits on
// every machine: only IEEE operations, no tables.
#include <bit>
#include <cmath>
#include <cstdint>

namespace sightline {

/// Largest integer ≤ x, for |x| < 2³¹; baseline x86 has no instruction for it.
inline int floor_to_int(float x) {
    const int i = static_cast<int>(x);
    return i - (x < static_cast<float>(i) ? 1 : 0);
}

/// log₂ x for positive normal x, to 0.01; exact at powers of two.
inline float fast_log2(float x) {
    const auto bits = std::bit_cast<uint32_t>(x);
    const float mantissa = std::bit_cast<float>((bits & 0x7fffffu) | 0x3f800000u) - 1;
    const int exponent = static_cast<int>(bits >> 23) - 127;
    return static_cast<float>(exponent) + mantissa * (1.3465f - 0.3465f * mantissa);
}

/// x⁵
inline float pow5(float x) {
    const float x2 = x * x;
    return x2 * x2 * x;
}

}  // namespace sightline
