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
    float blur = 0, tilt = 0;
    if (ray.origin_error != 0 || ray.direction_error != 0) {
        tilt = ray.direction_error * (extent / fastest);
        blur = (ray.origin_error + 2 * tilt) * (1 + 0x1p-10f);
    }
    const float least = 0x1p-30f * fastest + 4 * ray.direction_error;
    for (int i = 0; i < 3; ++i) {
        float r = 1 / direction[i], margin = blur;
        if (std::abs(direction[i]) < least) [[unlikely]] {
            // Within the bounds a nearly parallel ray strays less than `margin` from its origin's
            // coordinate; the offsets let it stay for ever in the slabs that lie this close.
            margin += 0x1p-20f * extent + 16 * tilt;
            r = 4 * extent / (margin * fastest);
        }
        const float middle = origin[i] * r;
        const float slack = std::abs(r) * margin + 8 * unit * std::abs(middle);
        reciprocal[i] = r;
        near_offset[i] = -middle - slack;
        far_offset[i] = -middle + slack;
        near_plane[i] = static_cast<uint32_t>(2 * i + (r < 0));
        far_plane[i] = static_cast<uint32_t>(2 * i + (r >= 0));
    }
}

}  // namespace sightline
