#pragma once
// Cryptomatte 1.2 (Friedman & Jones 2015): who covers how much of a pixel, by hashed names.
#include "scene/scene.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sightline {

/// Ranks that are kept of a pixel, two to a layer.
inline constexpr size_t cryptomatte_ranks = 6;

/// MurmurHash3_x86_32 with seed 0 (Appleby).
uint32_t murmur3(std::string_view text);

/// The id of a name: its hash, changed where its bits would be no normal float.
uint32_t cryptomatte_id(std::string_view name);

/// The names that objects and materials are known by; numbered where the file gives none.
std::vector<std::string> object_names(const Scene& scene);
std::vector<std::string> material_names(const Scene& scene);

/// How much of a pixel something covers, by id.
using Coverage = std::pair<uint32_t, float>;

/// Sums what has one id and orders by coverage, largest first; at most cryptomatte_ranks.
std::vector<Coverage> rank(std::vector<Coverage> coverage);

}  // namespace sightline
