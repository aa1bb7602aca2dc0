#include "core/sampler.h"

#include "core/vectorise.h"

#include <cassert>

namespace sightline {
namespace {

[[gnu::always_inline]] inline uint32_t reverse_bits(uint32_t x) {
    x = __builtin_bswap32(x);
    x = (x & 0x0f0f0f0fu) << 4 | (x >> 4 & 0x0f0f0f0fu);
    x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
    return (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
}

// Owen scrambling of reversed bits by a hash in which only lower bits affect a bit
// (Laine & Karras 2011, with Vegdahl's constants).
[[gnu::always_inline]] inline uint32_t scramble_reversed(uint32_t x, uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= seed >> 16 | 1;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

[[gnu::always_inline]] inline uint32_t owen_scramble(uint32_t x, uint32_t seed) {
    return reverse_bits(scramble_reversed(reverse_bits(x), seed));
}

// The generator matrix of Sobol's second dimension is Pascal's triangle modulo 2, the fifth
// Kronecker power of ((1,1),(0,1)): five masked shifts multiply by it. The bits are those of the
// fraction, lowest first.
[[gnu::always_inline]] inline uint32_t sobol_second_reversed(uint32_t index) {
    uint32_t x = index;
    x ^= x >> 1 & 0x55555555u;
    x ^= x >> 2 & 0x33333333u;
    x ^= x >> 4 & 0x0f0f0f0fu;
    x ^= x >> 8 & 0x00ff00ffu;
    return x ^ x >> 16;
}

// Signed, since processors convert signed integers to floats.
[[gnu::always_inline]] inline float to_unit(uint32_t x) {
    return static_cast<float>(static_cast<int32_t>(x >> 8)) * 0x1p-24f;
}

[[gnu::always_inline]] inline void sample_one(uint32_t index, uint32_t seed, float& x, float& y) {
    const uint32_t shuffled = owen_scramble(index, seed);
    // The first dimension's fraction is the index reversed, so its lowest bits first are the index.
    const uint32_t a = scramble_reversed(shuffled, hash_combine(seed, 0));
    const uint32_t b = scramble_reversed(sobol_second_reversed(shuffled), hash_combine(seed, 1));
    x = to_unit(reverse_bits(a));
    y = to_unit(reverse_bits(b));
}

[[gnu::always_inline]] inline void sample_all(const uint32_t* indices, const uint32_t* seeds,
                                              uint32_t dimension, size_t count, float* __restrict x,
                                              float* __restrict y) {
    for (size_t i = 0; i < count; ++i)
        sample_one(indices[i], hash_combine(seeds[i], dimension), x[i], y[i]);
}

}  // namespace

Vec2 sample_2d(uint32_t index, uint32_t seed) {
    Vec2 point;
    sample_one(index, seed, point.x, point.y);
    return point;
}

void sample_2d(std::span<const uint32_t> indices, std::span<const uint32_t> seeds,
               uint32_t dimension, std::span<float> x, std::span<float> y) {
    assert(seeds.size() == indices.size() && x.size() == indices.size() && y.size() == x.size());
    static const auto sample = best_version<sample_all, const uint32_t*, const uint32_t*, uint32_t,
                                            size_t, float*, float*>();
    sample(indices.data(), seeds.data(), dimension, indices.size(), x.data(), y.data());
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
