#pragma once
// Short approximations for shading, where libm's last bits cost more than they show. The same bits
// on every machine: only IEEE operations, no tables.
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

/// arctan x for x in [0,1], to 2e-7.
inline float fast_atan_unit(float x) {
    // Chebyshev series of atan(√s)/√s, cut after s⁸.
    constexpr float c[] = {0.999999984f,  -0.333330668f, 0.199924836f,  -0.142025705f, 0.106367541f,
                           -0.074954454f, 0.042587607f,  -0.016005030f, 0.002834064f};
    const float s = x * x;
    float sum = c[8];
    for (int i = 7; i >= 0; --i) sum = sum * s + c[i];
    return x * sum;
}

/// atan2(y, x) in (−π, π]; 0 where both are 0.
inline float fast_atan2(float y, float x) {
    constexpr float pi_f = 3.14159265358979f;
    const float ax = std::fabs(x), ay = std::fabs(y);
    const float high = ax > ay ? ax : ay, low = ax > ay ? ay : ax;
    float angle = high > 0 ? fast_atan_unit(low / high) : 0;
    if (ay > ax) angle = pi_f / 2 - angle;
    if (x < 0) angle = pi_f - angle;
    return y < 0 ? -angle : angle;
}

/// x⁵
inline float pow5(float x) {
    const float x2 = x * x;
    return x2 * x2 * x;
}

}  // namespace sightline
