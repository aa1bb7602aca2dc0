#pragma once
#include "core/math.h"

#include <span>

namespace sightline {

/// A well-mixed hash of two words (the finaliser of Steele et al.'s SplitMix on their mixture).
[[gnu::always_inline]] inline uint32_t hash_combine(uint32_t a, uint32_t b) {
    uint64_t x = (static_cast<uint64_t>(a) << 32 | b) + 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return static_cast<uint32_t>(x >> 32 ^ x);
}

/// Point `index` of an Owen-scrambled (0,2)-sequence in [0,1)², shuffled and scrambled by `seed`
/// (Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4) 2020). The sequences of different
/// seeds are independent; each dimension of a path has its own seed.
Vec2 sample_2d(uint32_t index, uint32_t seed);

/// The same for many points at once, each with the seed hash_combine(seeds[i], dimension).
void sample_2d(std::span<const uint32_t> indices, std::span<const uint32_t> seeds,
               uint32_t dimension, std::span<float> x, std::span<float> y);

/// The same in one dimension.
float sample_1d(uint32_t index, uint32_t seed);

/// The concentric map of the unit square to the unit disc (Shirley & Chiu 1997).
Vec2 sample_disc(Vec2 u);

}  // namespace sightline
