#pragma once
// Bounding volume hierarchies with eight children per node, over anything that has a box.
#include "core/math.h"

#include <cassert>
#include <span>
#include <vector>

namespace sightline {

/// A child of a node: an inner node, a leaf (a run of 1 to 16 blocks), or nothing.
class NodeRef {
  public:
    static constexpr uint32_t max_blocks = 16;

    /// Uninitialised, so that stacks of references need not be cleared.
    NodeRef() = default;
    static NodeRef nothing() { return NodeRef(none); }
    static NodeRef node(uint32_t index) { return NodeRef(index); }
    static NodeRef leaf(uint32_t first, uint32_t count) {
        assert(count >= 1 && count <= max_blocks && first < 1u << 27);
        return NodeRef(leaf_bit | first << 4 | (count - 1));
    }

    bool is_nothing() const { return bits_ == none; }
    bool is_leaf() const { return (bits_ & leaf_bit) != 0; }
    uint32_t index() const { return bits_; }                           ///< of the inner node
    uint32_t first() const { return (bits_ & ~leaf_bit) >> 4; }        ///< block of the leaf
    uint32_t count() const { return (bits_ & (max_blocks - 1)) + 1; }  ///< blocks of the leaf

  private:
    static constexpr uint32_t leaf_bit = 0x80000000u;
    explicit NodeRef(uint32_t bits) : bits_(bits) {}

    uint32_t bits_;
};

/// Eight child boxes as arrays, so that one vector holds a plane of each. Unused boxes are empty.
struct alignas(64) BvhNode {
    float planes[6][8];  ///< min x, max x, min y, max y, min z, max z
    NodeRef children[8];
};

/// A hierarchy, and the order in which its leaves hold the primitives that it was built over. A
/// block is a group of primitives that are tested together: eight triangles, or one object.
struct Bvh {
    struct Leaf {
        uint32_t begin, end;  ///< into `order`
    };

    std::vector<BvhNode> nodes;
    NodeRef root = NodeRef::nothing();
    Box3 bounds;
    float extent = 0;             ///< the largest absolute coordinate of the bounds
    std::vector<uint32_t> order;  ///< indices of the primitives, leaf after leaf
    std::vector<Leaf> leaves;     ///< in the order of their blocks
    uint32_t blocks = 0;
};

/// Builds by the surface area heuristic over 32 bins (Wald, On fast Construction of SAH-based
/// Bounding Volume Hierarchies, 2007). A block holds `block_size` primitives and costs as much to
/// test as one: `block_cost` times as much as two child boxes. Boxes must be finite.
Bvh build_bvh(std::span<const Box3> boxes, uint32_t block_size, float block_cost = 1);

}  // namespace sightline
