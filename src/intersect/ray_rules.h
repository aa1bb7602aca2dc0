#pragma once
// Which rays can hit anything, and from which t: the same rules for every intersector.
#include "core/ray.h"

#include <algorithm>
#include <bit>

namespace sightline {

/// The smallest t that counts as a hit of a ray with this tnear ≥ 0: the next float. Engines differ
/// on t == tnear; this makes tnear exclusive.
inline float next_after_tnear(float tnear) {
    return std::bit_cast<float>(std::bit_cast<uint32_t>(tnear + 0.0f) + 1);
}

/// False for a ray that hits nothing by definition (see Intersector). Without branches, so that
/// loops over many rays become vector code.
inline bool is_valid(const Ray& ray) {
    const Vec3 &o = ray.origin, &d = ray.direction;
    const float zero = o.x * 0 + o.y * 0 + o.z * 0 + d.x * 0 + d.y * 0 + d.z * 0 + ray.tnear * 0;
    const bool finite = zero == 0, has_direction = max_abs_component(d) > 0,
               forwards = ray.tnear >= 0, not_empty = ray.tnear < ray.tfar;
    return (int(finite) & int(has_direction) & int(forwards) & int(not_empty)) != 0;
}

/// A ray as an engine in single precision accepts it.
struct EngineRay {
    Ray ray;
    float t_scale = 1;  ///< multiply the engine's t by this
    bool valid = false;
};

/// Whether a direction's components would be lost or overflow in single precision.
inline bool is_extreme(const Vec3& direction) {
    const float length = max_abs_component(direction);
    return (int(length < 0x1p-20f) | int(length > 0x1p20f)) != 0;
}

/// Makes tnear exclusive, and scales a direction of extreme length to the order of 1 by a power of
/// two: engines lose components below 1e-18 and overflow on long ones. A ray whose origin has a
/// coordinate beyond `max_coordinate` is not valid.
inline EngineRay engine_ray(const Ray& ray, float max_coordinate) {
    EngineRay out{ray, 1, is_valid(ray) && max_abs_component(ray.origin) <= max_coordinate};
    out.ray.tnear = next_after_tnear(ray.tnear);
    if (out.valid && is_extreme(ray.direction)) {
        const int exponent = std::clamp(std::ilogb(max_abs_component(ray.direction)), -126, 126);
        out.t_scale = std::ldexp(1.0f, -exponent);
        out.ray.direction *= out.t_scale;
        out.ray.tnear =
            std::max(std::ldexp(ray.tnear, exponent), std::numeric_limits<float>::min());
        out.ray.tfar = std::ldexp(ray.tfar, exponent);
        out.valid = out.ray.tnear <= out.ray.tfar;
    }
    return out;
}

}  // namespace sightline
