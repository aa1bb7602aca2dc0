#include "render/sampler.h"

namespace sightline {
namespace {

uint32_t reverse_bits(uint32_t x) {
    x = __builtin_bswap32(x);
    x = (x & 0x0f0f0f0fu) << 4 | (x >> 4 & 0x0f0f0f0fu);
    x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
    return (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
}

// Owen scrambling of reversed bits by a hash in which each bit is flipped by lower bits alone
// (Laine & Karras 2011, with Vegdahl's constants).
uint32_t scramble_reversed(uint32_t x, uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= seed >> 16 | 1;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

uint32_t owen_scramble(uint32_t x, uint32_t seed) {
    return reverse_bits(scramble_reversed(reverse_bits(x), seed));
}

// The generator matrix of Sobol's second dimension is Pascal's triangle modulo 2, the fifth
// Kronecker power of ((1,1),(0,1)): five masked shifts multiply by it. The bits are those of the
// fraction, lowest first.
uint32_t sobol_second_reversed(uint32_t index) {
    uint32_t x = index;
    x ^= x >> 1 & 0x55555555u;
    x ^= x >> 2 & 0x33333333u;
    x ^= x >> 4 & 0x0f0f0f0fu;
    x ^= x >> 8 & 0x00ff00ffu;
    return x ^ x >> 16;
}

float to_unit(uint32_t x) { return static_cast<float>(x >> 8) * 0x1p-24f; }

}  // namespace

Vec2 sample_2d(uint32_t index, uint32_t seed) {
    const uint32_t shuffled = owen_scramble(index, seed);
    // The first dimension's fraction is the index reversed, so its lowest bits first are the index.
    const uint32_t x = scramble_reversed(shuffled, hash_combine(seed, 0));
    const uint32_t y = scramble_reversed(sobol_second_reversed(shuffled), hash_combine(seed, 1));
    return {to_unit(reverse_bits(x)), to_unit(reverse_bits(y))};
}

float sample_1d(uint32_t index, uint32_t seed) {
    const uint32_t shuffled = owen_scramble(index, seed);
    return to_unit(reverse_bits(scramble_reversed(shuffled, hash_combine(seed, 0))));
}

Vec2 sample_disc(Vec2 u) {
    const float x = 2 * u.x - 1, y = 2 * u.y - 1;
    if (x == 0 && y == 0) return {0, 0};
    const bool wide = std::fabs(x) > std::fabs(y);
    const float radius = wide ? x : y;
    const float angle = wide ? pi / 4 * (y / x) : pi / 2 - pi / 4 * (x / y);
    return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace sightline
