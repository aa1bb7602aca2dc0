#include "intersect/bvh/bvh.h"

#include "core/memory.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace sightline {
namespace {

constexpr float traversal_cost = 1;  // of testing two child boxes
constexpr int max_bins = 32;
constexpr int max_heuristic_depth = 32;  // below it, halving bounds the depth of the hierarchy

/// A primitive: its box and its index in the input.
struct Primitive {
    Box3 box;
    uint32_t index;
};

/// Two children, or a range of primitives.
struct BinaryNode {
    Box3 box;
    uint32_t left = none, right = none;
    uint32_t begin = 0, end = 0;

    bool is_leaf() const { return left == none; }
};

float float_half_area(const Box3& box) {
    if (box.isEmpty()) return 0;
    const Vec3 s = box.max - box.min;
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

Vec3 centre(const Box3& box) { return box.min * 0.5f + box.max * 0.5f; }

struct Split {
    float cost = std::numeric_limits<float>::infinity();
    int axis = -1, bin = 0;
};

/// Makes `box` contain `other`; by minima and maxima, which need no branches.
void extend(Box3& box, const Box3& other) {
    for (int i = 0; i < 3; ++i) {
        box.min[i] = std::min(box.min[i], other.min[i]);
        box.max[i] = std::max(box.max[i], other.max[i]);
    }
}

/// Maps a box centre to a bin along one axis. Few primitives need only few bins.
struct Binning {
    float low, scale;
    int bins;

    Binning(const Box3& centres, int axis, uint32_t count)
        : low(centres.min[axis]),
          bins(count < 64     ? 8
               : count < 1024 ? 16
                              : max_bins) {
        const float width = centres.max[axis] - low;
        scale = width > 0 ? static_cast<float>(bins) * 0.999f / width : 0;
    }
    int operator()(float position) const {
        const float bin = std::max(0.0f, (position - low) * scale);  // 0 for a NaN
        return static_cast<int>(std::min(bin, static_cast<float>(bins - 1)));
    }
};

/// The contents of the bins of one axis.
struct Bins {
    std::array<Box3, max_bins> boxes;
    std::array<uint32_t, max_bins> counts{};
};

class Builder {
  public:
    Builder(std::span<const Box3> boxes, uint32_t block_size, float block_cost)
        : block_size_(block_size), block_cost_(block_cost) {
        primitives_.reserve(boxes.size());
        for (uint32_t i = 0; i < boxes.size(); ++i) primitives_.push_back({boxes[i], i});
        nodes_.reserve(2 * boxes.size() / block_size + 1);
    }

    Bvh build() {
        Bvh bvh;
        if (primitives_.empty()) return bvh;
        const uint32_t root = divide(0, static_cast<uint32_t>(primitives_.size()), 0);
        bvh.bounds = nodes_[root].box;
        for (int i = 0; i < 3; ++i)
            bvh.extent =
                std::max({bvh.extent, std::abs(bvh.bounds.min[i]), std::abs(bvh.bounds.max[i])});
        bvh.order.reserve(primitives_.size());
        bvh.root = collapse(root, bvh);
        std::vector<BvhNode> nodes;  // the size is known only now
        reserve_in_large_pages(nodes, bvh.nodes.size());
        nodes.assign(bvh.nodes.begin(), bvh.nodes.end());
        bvh.nodes.swap(nodes);
        return bvh;
    }

  private:
    float cost_of_blocks(uint32_t count) const {
        const uint32_t blocks = (count + block_size_ - 1) / block_size_;
        return block_cost_ * static_cast<float>(blocks);
    }

    uint32_t divide(uint32_t begin, uint32_t end, int depth) {
        const auto index = static_cast<uint32_t>(nodes_.size());
        nodes_.emplace_back();
        Box3 box, centres;
        for (uint32_t i = begin; i < end; ++i) {
            const Vec3 middle = centre(primitives_[i].box);
            extend(box, primitives_[i].box);
            extend(centres, {middle, middle});
        }
        nodes_[index] = {box, none, none, begin, end};
        const uint32_t count = end - begin;
        if (count == 1) return index;
        const Split split =
            depth < max_heuristic_depth ? best_split(begin, end, box, centres) : Split();
        const bool fits = count <= block_size_ * NodeRef::max_blocks;
        if (fits && cost_of_blocks(count) <= split.cost) return index;
        const uint32_t middle =
            split.axis >= 0 ? partition(begin, end, centres, split) : halve(begin, end, centres);
        const uint32_t left = divide(begin, middle, depth + 1);
        const uint32_t right = divide(middle, end, depth + 1);
        nodes_[index].left = left;
        nodes_[index].right = right;
        return index;
    }

    Split best_split(uint32_t begin, uint32_t end, const Box3& box, const Box3& centres) const {
        const uint32_t count = end - begin;
        const Binning binnings[] = {{centres, 0, count}, {centres, 1, count}, {centres, 2, count}};
        Bins bins[3];
        for (uint32_t i = begin; i < end; ++i) {
            const Vec3 middle = centre(primitives_[i].box);
            for (int axis = 0; axis < 3; ++axis) {
                const auto bin = static_cast<size_t>(binnings[axis](middle[axis]));
                extend(bins[axis].boxes[bin], primitives_[i].box);
                ++bins[axis].counts[bin];
            }
        }
        Split best;
        for (int axis = 0; axis < 3; ++axis)
            if (binnings[axis].scale > 0)
                sweep(axis, bins[axis], static_cast<size_t>(binnings[axis].bins),
                      float_half_area(box), best);
        return best;
    }

    /// Evaluates the splits between the bins of one axis, by a sweep from either end.
    void sweep(int axis, const Bins& bins, size_t bin_count, float area, Split& best) const {
        std::array<float, max_bins> right_cost;
        Box3 box;
        uint32_t count = 0;
        for (size_t i = bin_count - 1; i > 0; --i) {
            extend(box, bins.boxes[i]);
            count += bins.counts[i];
            right_cost[i] = float_half_area(box) * cost_of_blocks(count);
        }
        const uint32_t total = count + bins.counts[0];
        box.makeEmpty();
        count = 0;
        for (size_t i = 1; i < bin_count; ++i) {
            extend(box, bins.boxes[i - 1]);
            count += bins.counts[i - 1];
            if (count == 0 || count == total) continue;
            const float cost =
                traversal_cost +
                (area > 0 ? (float_half_area(box) * cost_of_blocks(count) + right_cost[i]) / area
                          : 0);
            if (cost < best.cost) best = {cost, axis, static_cast<int>(i)};
        }
    }

    uint32_t partition(uint32_t begin, uint32_t end, const Box3& centres, const Split& split) {
        const Binning binning(centres, split.axis, end - begin);
        const auto middle =
            std::partition(primitives_.begin() + begin, primitives_.begin() + end,
                           [&](const Primitive& primitive) {
                               return binning(centre(primitive.box)[split.axis]) < split.bin;
                           });
        return static_cast<uint32_t>(middle - primitives_.begin());
    }

    uint32_t halve(uint32_t begin, uint32_t end, const Box3& centres) {
        const auto axis = static_cast<int>(centres.majorAxis());
        const uint32_t middle = begin + (end - begin) / 2;
        std::nth_element(primitives_.begin() + begin, primitives_.begin() + middle,
                         primitives_.begin() + end, [&](const Primitive& a, const Primitive& b) {
                             const float x = centre(a.box)[axis], y = centre(b.box)[axis];
                             return x != y ? x < y : a.index < b.index;
                         });
        return middle;
    }

    /// Converts the binary subtree at `index` to nodes of up to eight children: the child with the
    /// largest box is replaced by its own children until there are eight.
    NodeRef collapse(uint32_t index, Bvh& bvh) const {
        const BinaryNode& node = nodes_[index];
        if (node.is_leaf()) {
            const uint32_t first = bvh.blocks,
                           count = (node.end - node.begin + block_size_ - 1) / block_size_;
            const auto begin = static_cast<uint32_t>(bvh.order.size());
            for (uint32_t i = node.begin; i < node.end; ++i)
                bvh.order.push_back(primitives_[i].index);
            bvh.leaves.push_back({begin, static_cast<uint32_t>(bvh.order.size())});
            bvh.blocks += count;
            return NodeRef::leaf(first, count);
        }
        std::vector<uint32_t> children = {node.left, node.right};
        while (children.size() < 8) {
            const auto area = [&](uint32_t child) {
                return nodes_[child].is_leaf() ? -1 : float_half_area(nodes_[child].box);
            };
            const auto largest =
                std::max_element(children.begin(), children.end(),
                                 [&](uint32_t a, uint32_t b) { return area(a) < area(b); });
            if (nodes_[*largest].is_leaf()) break;
            const BinaryNode& opened = nodes_[*largest];
            *largest = opened.left;
            children.push_back(opened.right);
        }
        const auto slot = static_cast<uint32_t>(bvh.nodes.size());
        bvh.nodes.push_back(make_node(children));
        for (size_t i = 0; i < children.size(); ++i) {
            const NodeRef child = collapse(children[i], bvh);
            bvh.nodes[slot].children[i] = child;
        }
        return NodeRef::node(slot);
    }

    BvhNode make_node(const std::vector<uint32_t>& children) const {
        BvhNode wide;
        std::fill_n(wide.children, 8, NodeRef::nothing());
        for (size_t i = 0; i < 8; ++i)
            for (int axis = 0; axis < 3; ++axis) {
                // An empty box must stay empty when multiplied by a number of either sign.
                const bool used = i < children.size();
                wide.planes[2 * axis][i] =
                    used ? nodes_[children[i]].box.min[axis] : std::numeric_limits<float>::max();
                wide.planes[2 * axis + 1][i] =
                    used ? nodes_[children[i]].box.max[axis] : -std::numeric_limits<float>::max();
            }
        return wide;
    }

    uint32_t block_size_;
    float block_cost_;
    std::vector<Primitive> primitives_;
    std::vector<BinaryNode> nodes_;
};

}  // namespace

Bvh build_bvh(std::span<const Box3> boxes, uint32_t block_size, float block_cost) {
    return Builder(boxes, block_size, block_cost).build();
}

}  // namespace sightline
