#pragma once
// What the vectorised traversal works on. Its float arithmetic never decides what it cannot prove:
// boxes are tested conservatively, and a triangle is offered to a judge either as surely hit at a t
// within given bounds, or as doubtful.
#include "core/ray.h"
#include "intersect/bvh/bvh.h"
#include "intersect/bvh/tree_ray.h"

namespace sightline {

/// Eight triangles as arrays, in five lines of memory. Lanes beyond the last triangle repeat it.
struct alignas(64) TriangleBlock {
    float a[3][8];         ///< the first vertex
    float ab[3][8];        ///< from it to the second, rounded
    float ac[3][8];        ///< from it to the third, rounded
    uint32_t triangle[8];  ///< its number in the tree
};
static_assert(sizeof(TriangleBlock) == 320);

/// A tree over triangles of one space.
struct TriangleTree {
    BoxTree boxes;
    std::vector<TriangleBlock> blocks;
    float largest_edge = 0;  ///< no less than |ab|₁ and |ac|₁ of any
};

/// What the traversal found about one triangle.
struct Finding {
    uint32_t triangle;
    bool certain;     ///< false: whether it is hit at all must be decided exactly
    float low, high;  ///< enclose t where the line hits
};

/// Decides about what is found, and how far there is to go.
class Judge {
  public:
    virtual ~Judge() = default;

    /// Takes in a triangle; returns true where the search may stop.
    virtual bool offer(const Finding& finding) = 0;

    /// Takes in a leaf of a tree of boxes: `count` units from `first`; true: stop.
    virtual bool visit(uint32_t first, uint32_t count) = 0;

    /// No t beyond this is of interest; in the tree ray's measure, as all t here.
    float reach = std::numeric_limits<float>::infinity();

    /// A certain finding between these, `low` and `high` alike, is nearer than all before and lies
    /// within the segment: the traversal notes it as `found` instead of offering it.
    float sure_from = std::numeric_limits<float>::infinity();
    float sure_to = -std::numeric_limits<float>::infinity();
    bool stops_at_sure = false;
    uint32_t found = none;  ///< the triangle's number
};

/// Visits the triangles that the ray may hit with t ≤ judge.reach, near ones first. True: it
/// stopped.
bool traverse(const TriangleTree& tree, const TreeRay& ray, Judge& judge);

/// Visits the leaves whose boxes the ray may enter with t ≤ judge.reach, near ones first. True: it
/// stopped.
bool traverse(const BoxTree& tree, const TreeRay& ray, Judge& judge);

/// A ray on its way through a tree together with others.
struct Wanderer {
    const TreeRay* ray;
    Judge* judge;
    bool stopped = false;  ///< as the result of `traverse`
};

/// As `traverse` for each.
void traverse_each(const TriangleTree& tree, std::span<Wanderer> wanderers);

/// The same with a dozen in flight: while one waits for memory the others compute.
void traverse_wave(const TriangleTree& tree, std::span<Wanderer> wanderers);

/// The instruction set that the traversal uses on this machine.
const char* vector_target();

}  // namespace sightline
