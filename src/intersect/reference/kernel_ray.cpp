#include "intersect/reference/kernel.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr float unit = 0x1p-24f;  // of rounding to nearest

float largest(const Vec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

}  // namespace

TreeRay::TreeRay(const LocalRay& ray, const Box3& bounds, float largest_edge)
    : origin(ray.origin), direction(ray.direction), tnear(ray.tnear), fastest(largest(direction)) {
    // An error of the origin weighs as much as 8 units of rounding of a distance `reach`; see
    // test_block for the units that the bound of a triangle allows.
    reach = ray.origin_error / (8 * unit);
    direction_doubt = std::max(1.0f, ray.direction_error / (2 * unit * fastest));
    underflow = 0x1p-118f * (1 + largest_edge) * (1 + fastest);

    const float extent =
        largest(origin) + std::max({largest(bounds.min), largest(bounds.max), 1e-30f});
    // The ray leaves the bounds before t = 2·extent/fastest.
    const float blur =
        (ray.origin_error + 2 * ray.direction_error * (extent / fastest)) * (1 + 0x1p-10f);
    for (int i = 0; i < 3; ++i) {
        const float o = origin[i], d = direction[i];
        const bool parallel = std::abs(d) < 0x1p-30f * fastest + 4 * ray.direction_error;
        // Within the bounds a nearly parallel ray strays less than `margin` from its origin's
        // coordinate; the offsets let it enter for ever the slabs that lie this close.
        const float margin =
            parallel ? 0x1p-20f * extent + 16 * ray.direction_error * (extent / fastest) + blur
                     : blur;
        const float r = parallel ? 4 * extent / (margin * fastest) : 1 / d;
        const float slack = std::abs(r) * margin + 8 * unit * std::abs(o * r);
        reciprocal[i] = r;
        near_offset[i] = -o * r - slack;
        far_offset[i] = -o * r + slack;
        near_plane[i] = static_cast<uint32_t>(2 * i + (r < 0));
        far_plane[i] = static_cast<uint32_t>(2 * i + (r >= 0));
    }
}

}  // namespace sightline
