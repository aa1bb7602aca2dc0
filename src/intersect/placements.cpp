#include "intersect/placements.h"

#include <fmt/format.h>

namespace sightline {

void Placements::leave_out_triangles(const Mesh& mesh, float limit) {
    const auto usable = [&](uint32_t vertex) {
        const Vec3& p = mesh.positions[vertex];
        return std::fabs(p.x) <= limit && std::fabs(p.y) <= limit && std::fabs(p.z) <= limit;
    };
    for (const auto& [a, b, c] : mesh.triangles)
        triangles_left_out_ += !(usable(a) && usable(b) && usable(c));
}

std::vector<std::string> Placements::warnings() const {
    std::vector<std::string> lines;
    if (triangles_left_out_ > 0)
        lines.push_back(
            fmt::format("{} triangles are left out: they have a coordinate that is NaN, "
                        "infinite or too large",
                        triangles_left_out_));
    if (instances_left_out_ > 0)
        lines.push_back(fmt::format("{} instances are left out: their matrices have no inverse",
                                    instances_left_out_));
    return lines;
}

bool has_inverse(const Mat4& m) {
    const float determinant =
        dot(Vec3(m[0][0], m[0][1], m[0][2]),
            cross(Vec3(m[1][0], m[1][1], m[1][2]), Vec3(m[2][0], m[2][1], m[2][2])));
    return std::isnormal(determinant) && std::isnormal(1 / determinant);
}

}  // namespace sightline
