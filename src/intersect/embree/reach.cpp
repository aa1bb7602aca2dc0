#include "intersect/embree/reach.h"

#include <algorithm>
#include <cmath>

namespace sightline {

float max_world_coordinate(const Mat4& object_to_world) {
    constexpr auto limit = static_cast<double>(embree_max_coordinate);
    const Mat4d m(object_to_world);
    const Vec3d rows[] = {
        {m[0][0], m[0][1], m[0][2]}, {m[1][0], m[1][1], m[1][2]}, {m[2][0], m[2][1], m[2][2]}};
    const double lengths = rows[0].length() * rows[1].length() * rows[2].length();
    const double volume = std::abs(dot(rows[0], cross(rows[1], rows[2])));
    // Embree's determinant is off by up to 5·10⁻⁷ of the lengths: it must not be all error.
    if (!(volume > 1e-6 * lengths) || !std::isfinite(volume)) return 0;
    const Mat4d inverse = m.inverse();
    double largest = 1, shift = 0;
    for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) largest = std::max(largest, std::abs(inverse[r][c]));
        shift = std::max(shift, std::abs(inverse[3][c]));
    }
    const double result = limit / (4 * largest);
    // Directions are scaled to less than 2^20.
    return shift <= limit / 4 && result > 2e6 ? static_cast<float>(result) : 0;
}

float class_reach(unsigned reach_class) {
    return std::ldexp(embree_max_coordinate, -4 * static_cast<int>(reach_class));
}

unsigned reach_class_of(float max_coordinate) {
    unsigned c = 0;
    while (c + 1 < reach_classes && class_reach(c) > max_coordinate) ++c;
    return c;
}

unsigned spread_mask(unsigned mask, float coordinate) {
    unsigned spread = 0;
    for (unsigned c = 0; c < reach_classes && coordinate <= class_reach(c); ++c)
        spread |= mask << 2 * c;
    return spread;
}

}  // namespace sightline
