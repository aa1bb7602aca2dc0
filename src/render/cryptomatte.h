#pragma once
// Cryptomatte 1.2 (Friedman & Jones 2015): the coverage of each pixel, by hashed names.
#include "scene/scene.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sightline {

/// Ranks that are stored for each pixel, two in one EXR layer.
inline constexpr size_t cryptomatte_ranks = 6;

/// MurmurHash3_x86_32 with seed 0 (Appleby).
uint32_t murmur3(std::string_view text);

/// The id of a name: its hash, with a bit of the exponent flipped if it is not a normal float.
uint32_t cryptomatte_id(std::string_view name);

/// The names of objects (instances) and materials; numbered if the file has none.
std::vector<std::string> object_names(const Scene& scene);
std::vector<std::string> material_names(const Scene& scene);

/// An id and the share of a pixel that it covers.
using Coverage = std::pair<uint32_t, float>;

/// Sums the coverage of each id and sorts by it, largest first; at most cryptomatte_ranks.
std::vector<Coverage> rank(std::vector<Coverage> coverage);

}  // namespace sightline
