#pragma once
// Vectorised BVH traversal. Single precision never decides what it cannot prove: boxes are tested
// conservatively, and a triangle is reported either as a certain hit at a t within given bounds, or
// as a candidate that the visitor must decide.
//
// A traversal has three parts: a ray (TraversalRay), the state of the search (TraversalLimits),
// which the kernel reads and both sides tighten, and a visitor, which decides about candidates.
// Visitors are virtual, since the kernel is compiled once for each instruction set; only the
// few candidates that get as far pay for a call. All t are in the units of the traversal ray.
#include "core/ray.h"
#include "intersect/bvh/bvh.h"
#include "intersect/bvh/traversal_ray.h"

namespace sightline {

/// Eight triangles as arrays, in five cache lines. Lanes beyond the last triangle repeat it.
struct alignas(64) TriangleBlock {
    float a[3][8];         ///< the first vertex
    float ab[3][8];        ///< from it to the second, rounded
    float ac[3][8];        ///< from it to the third, rounded
    uint32_t triangle[8];  ///< its number in the BVH
};
static_assert(sizeof(TriangleBlock) == 320);

/// A BVH over triangles of one space.
struct TriangleBvh {
    Bvh bvh;
    std::vector<TriangleBlock> blocks;
    float max_edge = 0;  ///< no less than |ab|₁ and |ac|₁ of any triangle
};

/// A triangle that the kernel could not rule out.
struct TriangleCandidate {
    uint32_t triangle;
    bool certain;         ///< false: exact arithmetic must decide whether the line hits it
    float t_low, t_high;  ///< enclose t if the line hits
};

/// How far a search still has to go.
struct TraversalLimits {
    float t_max = std::numeric_limits<float>::infinity();  ///< nothing beyond it matters

    /// The kernel accepts a certain candidate with certain_t_min < t_low and t_high < certain_t_max
    /// by itself, without calling the visitor: it lies within the segment and before all hits so
    /// far. The default interval is empty.
    float certain_t_min = std::numeric_limits<float>::infinity();
    float certain_t_max = -std::numeric_limits<float>::infinity();
    bool stop_at_certain = false;
    uint32_t pending_triangle = none;  ///< the last one that the kernel accepted
};

/// Decides about triangles.
class TriangleVisitor {
  public:
    virtual ~TriangleVisitor() = default;

    /// Decides about a candidate and may tighten the limits. Returns true to stop the traversal.
    virtual bool on_triangle(const TriangleCandidate& candidate, TraversalLimits& limits) = 0;
};

/// Tests the contents of leaves.
class LeafVisitor {
  public:
    virtual ~LeafVisitor() = default;

    /// Tests blocks first … first + count − 1 and may tighten the limits. Returns true to stop.
    virtual bool on_leaf(uint32_t first, uint32_t count, TraversalLimits& limits) = 0;
};

/// Reports the triangles that the ray may hit with t ≤ limits.t_max, near ones first. Returns true
/// if the traversal was stopped.
bool traverse(const TriangleBvh& bvh, const TraversalRay& ray, TraversalLimits& limits,
              TriangleVisitor& visitor);

/// Reports the leaves whose boxes the ray may enter with t ≤ limits.t_max, near ones first. Returns
/// true if the traversal was stopped.
bool traverse(const Bvh& bvh, const TraversalRay& ray, TraversalLimits& limits,
              LeafVisitor& visitor);

/// The traversal of one ray among several.
struct TraversalJob {
    const TraversalRay* ray;
    TraversalLimits* limits;
    TriangleVisitor* visitor;
    bool stopped = false;  ///< the result of `traverse`
};

/// Traverses the BVH for one ray after another.
void traverse_each(const TriangleBvh& bvh, std::span<TraversalJob> jobs);

/// The same with a dozen rays in flight: while one waits for memory, others compute.
void traverse_interleaved(const TriangleBvh& bvh, std::span<TraversalJob> jobs);

/// The instruction set that the traversal uses on this machine.
const char* vector_target();

}  // namespace sightline
