#pragma once
// Trees of boxes, eight to a node, over whatever has a box.
#include "core/math.h"

#include <cassert>
#include <span>
#include <vector>

namespace sightline {

/// What a slot of a node leads to: an inner node, a leaf (a run of at most sixteen units: blocks
/// of triangles, or objects), or nothing.
class TreeLink {
  public:
    static constexpr uint32_t longest_run = 16;

    /// Leads nowhere in particular: stacks of links are not worth clearing.
    TreeLink() = default;
    static TreeLink nothing() { return TreeLink(none); }
    static TreeLink node(uint32_t index) { return TreeLink(index); }
    static TreeLink leaf(uint32_t first, uint32_t count) {
        assert(count >= 1 && count <= longest_run && first < 1u << 27);
        return TreeLink(leaf_bit | first << 4 | (count - 1));
    }

    bool is_nothing() const { return bits_ == none; }
    bool is_leaf() const { return (bits_ & leaf_bit) != 0; }
    uint32_t index() const { return bits_; }                            ///< of the inner node
    uint32_t first() const { return (bits_ & ~leaf_bit) >> 4; }         ///< unit of the leaf
    uint32_t count() const { return (bits_ & (longest_run - 1)) + 1; }  ///< units of the leaf

  private:
    static constexpr uint32_t leaf_bit = 0x80000000u;
    explicit TreeLink(uint32_t bits) : bits_(bits) {}

    uint32_t bits_;
};

/// Eight boxes as arrays, so that one vector holds a plane of all. Unused ones are empty.
struct alignas(64) WideNode {
    float planes[6][8];  ///< min x, max x, min y, max y, min z, max z
    TreeLink links[8];
};

/// A tree, and in which order its leaves hold what it was built over.
struct BoxTree {
    struct Leaf {
        uint32_t begin, end;  ///< into `order`
    };

    std::vector<WideNode> nodes;
    TreeLink root = TreeLink::nothing();
    Box3 bounds;
    float extent = 0;             ///< the largest coordinate of the bounds
    std::vector<uint32_t> order;  ///< indices of the boxes, leaf after leaf
    std::vector<Leaf> leaves;     ///< in the order of their units
    uint32_t units = 0;
};

/// Builds by the surface area heuristic over 32 bins (Wald, On fast Construction of SAH-based
/// Bounding Volume Hierarchies, 2007). `unit` boxes are tested at the cost of one: the vectors'
/// width. Boxes must be finite.
BoxTree build_tree(std::span<const Box3> boxes, uint32_t unit);

}  // namespace sightline
