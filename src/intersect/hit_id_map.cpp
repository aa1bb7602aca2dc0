#include "intersect/hit_id_map.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline {

void HitIdMap::count_dropped_triangles(std::span<const std::array<uint32_t, 3>> triangles,
                                       std::span<const Vec3> positions, float limit) {
    const auto usable = [&](uint32_t vertex) {
        const Vec3& p = positions[vertex];
        return std::fabs(p.x) <= limit && std::fabs(p.y) <= limit && std::fabs(p.z) <= limit;
    };
    uint32_t vertex = 0;
    while (vertex < positions.size() && usable(vertex)) ++vertex;
    if (vertex == positions.size()) return;
    for (const auto& [a, b, c] : triangles)
        dropped_triangles_ += !(usable(a) && usable(b) && usable(c));
}

std::vector<std::string> HitIdMap::warnings() const {
    std::vector<std::string> lines;
    if (dropped_triangles_ > 0)
        lines.push_back(
            fmt::format("{} triangles are left out: they have a coordinate that is NaN, "
                        "infinite or too large",
                        dropped_triangles_));
    if (dropped_shapes_ > 0)
        lines.push_back(fmt::format(
            "{} analytic shapes are left out: their instances' matrices have no usable inverse",
            dropped_shapes_));
    return lines;
}

}  // namespace sightline
