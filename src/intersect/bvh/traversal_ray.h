#pragma once
// Rays prepared for traversal. Inline, since preparation is as frequent as traversal.
#include "intersect/bvh/bvh.h"
#include "intersect/ray_rules.h"

#include <array>

namespace sightline {

/// A ray in the space of a BVH, with bounds of the errors of its components. Its t is that of the
/// world ray times a power of two.
struct LocalRay {
    Vec3 origin, direction;
    float tnear;
    float origin_error = 0, direction_error = 0;  ///< absolute, of each component
};

/// A ray prepared for the traversal of one BVH.
struct TraversalRay {
    Vec3 origin, direction;
    // By axis; the fourth element is unused.
    std::array<float, 4> reciprocal;   ///< of the direction; limited if nearly parallel to a slab
    std::array<float, 4> near_offset;  ///< −origin·reciprocal, less all rounding errors
    std::array<float, 4> far_offset;   ///< −origin·reciprocal, plus all rounding errors
    std::array<uint32_t, 4> near_plane, far_plane;  ///< indices into BvhNode::planes
    float tnear;
    // Terms of the triangle test's error bound (test_block in traversal_kernel.cpp):
    float origin_slack;     ///< a distance
    float direction_size;   ///< the direction's largest component, or more for its error
    float underflow_error;  ///< of an edge function, by products below the normal floats

    /// `max_edge` is TriangleBvh::max_edge, if the BVH is over triangles.
    TraversalRay(const LocalRay& ray, const Bvh& bvh, float max_edge = 0);

    /// Whether the ray may enter a box of the BVH at a t ≤ t_max: as the traversal tests those of
    /// nodes.
    bool may_enter(const Box3& box, float t_max) const;
};

namespace traversal_ray {

constexpr float unit = 0x1p-24f;  // of rounding to nearest

/// The origin's error as a distance: the triangle test allows eight units of rounding for each unit
/// of distance between the origin and a triangle, so this distance adds just as much.
inline float origin_slack(const LocalRay& ray) { return ray.origin_error * (1 / (8 * unit)); }

/// The size of the direction in the triangle test's error bound, which allows for two units of
/// rounding of it. Without branches, which would be mispredicted.
inline float direction_size(const LocalRay& ray, float max_abs_direction) {
    return std::max(max_abs_direction, ray.direction_error * (1 / (2 * unit)));
}

/// The three axes and a spare, in one register.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = int32_t __attribute__((vector_size(16)));

inline Float4 lanes(const Vec3& v, float spare) { return Float4{v.x, v.y, v.z, spare}; }
inline Float4 magnitude(Float4 v) {
    return std::bit_cast<Float4>(std::bit_cast<Int4>(v) & 0x7fffffff);
}

/// The slab test's constants: the direction's reciprocal, and by how far, as a distance, the ray
/// may stray from its line within the bounds.
struct Slabs {
    Float4 reciprocal, margin;
};

/// `extent` is that of the bounds seen from the ray's origin: the ray leaves them before
/// t = 2·extent/max_abs_direction.
inline Slabs prepare_slabs(const LocalRay& ray, float max_abs_direction, float extent) {
    float margin = 0, tilt = 0;  // distances
    if (ray.origin_error != 0 || ray.direction_error != 0) {
        tilt = ray.direction_error * (extent / max_abs_direction);
        margin = (ray.origin_error + 2 * tilt) * (1 + 0x1p-10f);
    }
    const Float4 d = lanes(ray.direction, 1);
    Slabs slabs{1 / d, Float4{} + margin};
    const Int4 parallel = magnitude(d) < 0x1p-30f * max_abs_direction + 4 * ray.direction_error;
    if (parallel[0] | parallel[1] | parallel[2]) [[unlikely]] {
        // Within the bounds a nearly parallel ray strays less than `wide` from its origin's
        // coordinate; the offsets keep it for ever within the slabs that lie this close.
        const float wide = margin + (0x1p-20f * extent + 16 * tilt);
        slabs.margin = parallel ? Float4{} + wide : slabs.margin;
        slabs.reciprocal =
            parallel ? Float4{} + 4 * extent / (wide * max_abs_direction) : slabs.reciprocal;
    }
    return slabs;
}

}  // namespace traversal_ray

inline TraversalRay::TraversalRay(const LocalRay& ray, const Bvh& bvh, float max_edge)
    : origin(ray.origin),
      direction(ray.direction),
      tnear(ray.tnear),
      origin_slack(traversal_ray::origin_slack(ray)) {
    using namespace traversal_ray;
    const float max_abs_direction = max_abs_component(direction);
    direction_size = traversal_ray::direction_size(ray, max_abs_direction);
    underflow_error = 0x1p-118f * (1 + max_edge) * (1 + max_abs_direction);
    const float extent = max_abs_component(origin) + std::max(bvh.extent, 1e-30f);
    const auto [r, margin] = prepare_slabs(ray, max_abs_direction, extent);
    const Float4 middle = lanes(origin, 0) * r;
    // Below the normal floats rounding is absolute: less than 2^-149 each time.
    const Float4 slack = magnitude(r) * margin + 8 * unit * magnitude(middle) + 0x1p-140f;
    reciprocal = std::bit_cast<std::array<float, 4>>(r);
    near_offset = std::bit_cast<std::array<float, 4>>(-middle - slack);
    far_offset = std::bit_cast<std::array<float, 4>>(-middle + slack);
    const Int4 negative = r < 0, first = {0, 2, 4, 6};
    near_plane = std::bit_cast<std::array<uint32_t, 4>>(first - negative);
    far_plane = std::bit_cast<std::array<uint32_t, 4>>(first + 1 + negative);
}

inline bool TraversalRay::may_enter(const Box3& box, float t_max) const {
    using namespace traversal_ray;
    constexpr float farther = 1 + 0x1p-20f;
    const Float4 r = std::bit_cast<Float4>(reciprocal), low = lanes(box.min, 0),
                 high = lanes(box.max, 0);
    const Int4 backwards = r < 0;
    const Float4 first = backwards ? high : low, last = backwards ? low : high;
    const Float4 entry = first * r + std::bit_cast<Float4>(near_offset),
                 exit = last * (r * farther) + std::bit_cast<Float4>(far_offset) * farther;
    return std::max({entry[0], entry[1], entry[2], tnear}) <=
           std::min({exit[0], exit[1], exit[2], t_max * farther});
}

}  // namespace sightline
