#pragma once
// Which rays can hit at all, and from where on: the same for every intersector.
#include "core/ray.h"

#include <algorithm>
#include <bit>

namespace sightline {

/// The smallest t that counts as a hit of a ray with this tnear ≥ 0: the next float beyond it, and
/// at least the smallest normal one. Engines differ on t == tnear; this makes tnear exclusive.
inline float beyond(float tnear) {
    const float next = std::bit_cast<float>(std::bit_cast<uint32_t>(tnear) + 1);
    return std::max(next, std::numeric_limits<float>::min());
}

/// False for a ray that hits nothing by definition (see Intersector).
inline bool is_valid(const Ray& ray) {
    const Vec3 &o = ray.origin, &d = ray.direction;
    const float zero = o.x * 0 + o.y * 0 + o.z * 0 + d.x * 0 + d.y * 0 + d.z * 0 + ray.tnear * 0;
    return zero == 0 && (d.x != 0 || d.y != 0 || d.z != 0) && ray.tnear >= 0 &&
           beyond(ray.tnear) <= ray.tfar;
}

}  // namespace sightline
