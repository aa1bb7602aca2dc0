#include "intersect/hit_id_map.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline {

void HitIdMap::count_dropped_triangles(const Mesh& mesh, float limit) {
    const auto usable = [&](uint32_t vertex) {
        const Vec3& p = mesh.positions[vertex];
        return std::fabs(p.x) <= limit && std::fabs(p.y) <= limit && std::fabs(p.z) <= limit;
    };
    for (const auto& [a, b, c] : mesh.triangles)
        dropped_triangles_ += !(usable(a) && usable(b) && usable(c));
}

std::vector<std::string> HitIdMap::warnings() const {
    std::vector<std::string> lines;
    if (dropped_triangles_ > 0)
        lines.push_back(
            fmt::format("{} triangles are left out: they have a coordinate that is NaN, "
                        "infinite or too large",
                        dropped_triangles_));
    if (dropped_instances_ > 0)
        lines.push_back(
            fmt::format("{} instances are left out: their matrices have no usable inverse",
                        dropped_instances_));
    return lines;
}

float max_world_coordinate(const Mat4& object_to_world, float limit) {
    const Mat4d m(object_to_world);
    const Vec3d rows[] = {
        {m[0][0], m[0][1], m[0][2]}, {m[1][0], m[1][1], m[1][2]}, {m[2][0], m[2][1], m[2][2]}};
    const double lengths = rows[0].length() * rows[1].length() * rows[2].length();
    const double volume = std::abs(dot(rows[0], cross(rows[1], rows[2])));
    // If the rows are nearly coplanar, a determinant in single precision is all error.
    if (!(volume > 1e-5 * lengths) || !std::isfinite(volume)) return 0;
    const Mat4d inverse = m.inverse();
    double largest = 1, shift = 0;
    for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) largest = std::max(largest, std::abs(inverse[r][c]));
        shift = std::max(shift, std::abs(inverse[3][c]));
    }
    const double result = double(limit) / (4 * largest);
    return shift <= double(limit) / 4 && result > 1e6 ? static_cast<float>(result) : 0;
}

}  // namespace sightline
