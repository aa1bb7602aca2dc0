#pragma once
// What the vectorised traversal works on. Its float arithmetic never decides what it cannot prove:
// boxes are tested conservatively, and a triangle is offered to a judge either as surely hit at a t
// within given bounds, or as doubtful.
#include "core/ray.h"
#include "intersect/reference/bvh.h"

#include <array>
#include <bit>

namespace sightline {

/// Eight triangles as arrays. Lanes beyond the last triangle repeat it.
struct alignas(64) TriangleBlock {
    float a[3][8];          ///< the first vertex
    float ab[3][8];         ///< from it to the second, rounded
    float ac[3][8];         ///< from it to the third, rounded
    uint32_t part[8];       ///< which of the tree's parts (meshes) the triangle belongs to
    uint32_t primitive[8];  ///< its index in the mesh
    float edge;             ///< no less than |ab|₁ and |ac|₁ of any
};

/// A tree over triangles of one space.
struct TriangleTree {
    BoxTree boxes;
    std::vector<TriangleBlock> blocks;
    float largest_edge = 0;
};

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

/// What the traversal found about one triangle.
struct Finding {
    uint32_t part, primitive;
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

    /// No t beyond this is of interest; in the tree ray's measure.
    float reach = std::numeric_limits<float>::infinity();
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

/// As `traverse` for each, a dozen in flight: while one waits for memory the others compute.
void traverse_wave(const TriangleTree& tree, std::span<Wanderer> wanderers);

/// The instruction set that the traversal uses on this machine.
const char* vector_target();

}  // namespace sightline
