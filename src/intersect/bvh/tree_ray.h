#pragma once
// Rays as the traversal of trees takes them. Inline: they are made ready as often as traced.
#include "intersect/bvh/bvh.h"

#include <algorithm>
#include <array>
#include <bit>

namespace sightline {

/// A ray in the space of a tree, and what its components may be off by. Its t is that of the world
/// ray times a power of two.
struct LocalRay {
    Vec3 origin, direction;
    float tnear;
    float origin_error = 0, direction_error = 0;
};

/// A ray made ready for the traversal of one tree.
struct TreeRay {
    Vec3 origin, direction;
    // By axis; the fourth is not used.
    std::array<float, 4> reciprocal;  ///< of the direction; large where nearly parallel to planes
    std::array<float, 4>
        near_offset;  ///< −origin·reciprocal, moved so that no rounding loses a box
    std::array<float, 4> far_offset;
    std::array<uint32_t, 4> near_plane;  ///< indices into WideNode::planes
    std::array<uint32_t, 4> far_plane;
    float tnear;
    float fastest;          ///< the direction's largest component
    float reach;            ///< the origin's error, as a distance in the triangles' error bound
    float direction_doubt;  ///< factor ≥ 1 of that bound for the direction's error
    float underflow;        ///< what products below the normal floats can cost an edge function

    TreeRay(const LocalRay& ray, const BoxTree& tree, float largest_edge = 0);
};

namespace tree_ray {

constexpr float unit = 0x1p-24f;  // of rounding to nearest

inline float largest(const Vec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// The three axes and a spare, in one register.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = int32_t __attribute__((vector_size(16)));

inline Float4 lanes(const Vec3& v, float spare) { return Float4{v.x, v.y, v.z, spare}; }
inline Float4 magnitude(Float4 v) {
    return std::bit_cast<Float4>(std::bit_cast<Int4>(v) & 0x7fffffff);
}

}  // namespace tree_ray

inline TreeRay::TreeRay(const LocalRay& ray, const BoxTree& tree, float largest_edge)
    : origin(ray.origin),
      direction(ray.direction),
      tnear(ray.tnear),
      fastest(tree_ray::largest(direction)) {
    using namespace tree_ray;
    // An error of the origin weighs as much as 8 units of rounding of a distance `reach`; see
    // test_block for the units that the bound of a triangle allows.
    reach = ray.origin_error * (1 / (8 * unit));
    direction_doubt =
        ray.direction_error == 0 ? 1 : std::max(1.0f, ray.direction_error / (2 * unit * fastest));
    underflow = 0x1p-118f * (1 + largest_edge) * (1 + fastest);

    const float extent = largest(origin) + std::max(tree.extent, 1e-30f);
    // The ray leaves the bounds before t = 2·extent/fastest.
    float blur = 0, tilt = 0;
    if (ray.origin_error != 0 || ray.direction_error != 0) {
        tilt = ray.direction_error * (extent / fastest);
        blur = (ray.origin_error + 2 * tilt) * (1 + 0x1p-10f);
    }
    const Float4 d = lanes(direction, 1);
    Float4 r = 1 / d, margin = Float4{} + blur;
    const Int4 parallel = magnitude(d) < 0x1p-30f * fastest + 4 * ray.direction_error;
    if (parallel[0] | parallel[1] | parallel[2]) [[unlikely]] {
        // Within the bounds a nearly parallel ray strays less than `margin` from its origin's
        // coordinate; the offsets let it stay for ever in the slabs that lie this close.
        const float wide = blur + (0x1p-20f * extent + 16 * tilt);
        margin = parallel ? Float4{} + wide : margin;
        r = parallel ? Float4{} + 4 * extent / (wide * fastest) : r;
    }
    const Float4 middle = lanes(origin, 0) * r;
    const Float4 slack = magnitude(r) * margin + 8 * unit * magnitude(middle);
    reciprocal = std::bit_cast<std::array<float, 4>>(r);
    near_offset = std::bit_cast<std::array<float, 4>>(-middle - slack);
    far_offset = std::bit_cast<std::array<float, 4>>(-middle + slack);
    const Int4 negative = r < 0, first = {0, 2, 4, 6};
    near_plane = std::bit_cast<std::array<uint32_t, 4>>(first - negative);
    far_plane = std::bit_cast<std::array<uint32_t, 4>>(first + 1 + negative);
}

}  // namespace sightline
