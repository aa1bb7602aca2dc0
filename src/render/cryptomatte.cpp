#include "render/cryptomatte.h"

#include "core/bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace sightline {
namespace {

uint32_t scramble(uint32_t k) { return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u; }

uint32_t word(std::string_view text) {
    return static_cast<uint32_t>(little_endian(std::as_bytes(std::span(text))));
}

}  // namespace

uint32_t murmur3(std::string_view text) {
    uint32_t h = 0;
    std::string_view rest = text;
    for (; rest.size() >= 4; rest.remove_prefix(4)) {
        h ^= scramble(word(rest.substr(0, 4)));
        h = std::rotl(h, 13) * 5 + 0xe6546b64u;
    }
    h ^= scramble(word(rest)) ^ static_cast<uint32_t>(text.size());
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

uint32_t cryptomatte_id(std::string_view name) {
    const uint32_t hash = murmur3(name);
    const uint32_t exponent = hash >> 23 & 255;
    return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

std::vector<std::string> object_names(const Scene& scene) {
    std::vector<std::string> names;
    for (const Instance& instance : scene.instances)
        names.push_back(instance.name.empty() ? fmt::format("object{}", names.size())
                                              : instance.name);
    return names;
}

std::vector<std::string> material_names(const Scene& scene) {
    std::vector<std::string> names;
    for (const Material& material : scene.materials)
        names.push_back(material.name.empty() ? fmt::format("material{}", names.size())
                                              : material.name);
    return names;
}

std::vector<Coverage> rank(std::vector<Coverage> coverage) {
    std::ranges::stable_sort(coverage, {}, &Coverage::first);
    std::vector<Coverage> ranks;
    for (const auto& [id, share] : coverage) {
        if (ranks.empty() || ranks.back().first != id) ranks.push_back({id, 0.0f});
        ranks.back().second += share;
    }
    std::ranges::stable_sort(ranks, std::ranges::greater(), &Coverage::second);
    if (ranks.size() > cryptomatte_ranks) ranks.resize(cryptomatte_ranks);
    return ranks;
}

}  // namespace sightline
