#include "intersect/bvh/bvh.h"

#include "core/pages.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace sightline {
namespace {

constexpr float traversal_cost = 1;  // of a step down two boxes, in tests of one unit
constexpr int most_bins = 32;
constexpr int deepest_heuristic_split = 32;  // halving from there on bounds the tree's depth

/// A box and where it came from.
struct Item {
    Box3 box;
    uint32_t index;
};

/// Two children each, or a range of items.
struct BinaryNode {
    Box3 box;
    uint32_t left = none, right = none;
    uint32_t begin = 0, end = 0;

    bool is_leaf() const { return left == none; }
};

float half_area(const Box3& box) {
    if (box.isEmpty()) return 0;
    const Vec3 s = box.max - box.min;
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

Vec3 centre(const Box3& box) { return box.min * 0.5f + box.max * 0.5f; }

struct Split {
    float cost = std::numeric_limits<float>::infinity();
    int axis = -1, bin = 0;
};

/// `box` made to hold `other`: minima and maxima, which need no branches.
void extend(Box3& box, const Box3& other) {
    for (int i = 0; i < 3; ++i) {
        box.min[i] = std::min(box.min[i], other.min[i]);
        box.max[i] = std::max(box.max[i], other.max[i]);
    }
}

/// Which of the bins along one axis a box falls into. Few boxes need but few bins.
struct Binning {
    float low, scale;
    int bins;

    Binning(const Box3& centres, int axis, uint32_t count)
        : low(centres.min[axis]),
          bins(count < 64     ? 8
               : count < 1024 ? 16
                              : most_bins) {
        const float width = centres.max[axis] - low;
        scale = width > 0 ? static_cast<float>(bins) * 0.999f / width : 0;
    }
    int operator()(float position) const {
        const float bin = std::max(0.0f, (position - low) * scale);  // 0 where it is no number
        return static_cast<int>(std::min(bin, static_cast<float>(bins - 1)));
    }
};

/// What fell into the bins of one axis.
struct Bins {
    std::array<Box3, most_bins> boxes;
    std::array<uint32_t, most_bins> counts{};
};

class Builder {
  public:
    Builder(std::span<const Box3> boxes, uint32_t unit) : unit_(unit) {
        items_.reserve(boxes.size());
        for (uint32_t i = 0; i < boxes.size(); ++i) items_.push_back({boxes[i], i});
        nodes_.reserve(2 * boxes.size() / unit + 1);
    }

    BoxTree build() {
        BoxTree tree;
        if (items_.empty()) return tree;
        const uint32_t root = divide(0, static_cast<uint32_t>(items_.size()), 0);
        tree.bounds = nodes_[root].box;
        for (int i = 0; i < 3; ++i)
            tree.extent =
                std::max({tree.extent, std::abs(tree.bounds.min[i]), std::abs(tree.bounds.max[i])});
        tree.order.reserve(items_.size());
        tree.root = collapse(root, tree);
        std::vector<WideNode> nodes;  // of the size that is now known
        reserve_in_large_pages(nodes, tree.nodes.size());
        nodes.assign(tree.nodes.begin(), tree.nodes.end());
        tree.nodes.swap(nodes);
        return tree;
    }

  private:
    float units(uint32_t count) const { return static_cast<float>((count + unit_ - 1) / unit_); }

    uint32_t divide(uint32_t begin, uint32_t end, int depth) {
        const auto index = static_cast<uint32_t>(nodes_.size());
        nodes_.emplace_back();
        Box3 box, centres;
        for (uint32_t i = begin; i < end; ++i) {
            const Vec3 middle = centre(items_[i].box);
            extend(box, items_[i].box);
            extend(centres, {middle, middle});
        }
        nodes_[index] = {box, none, none, begin, end};
        const uint32_t count = end - begin;
        if (count == 1) return index;
        const Split split =
            depth < deepest_heuristic_split ? best_split(begin, end, box, centres) : Split();
        const bool fits = count <= unit_ * TreeLink::longest_run;
        if (fits && units(count) <= split.cost) return index;
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
            const Vec3 middle = centre(items_[i].box);
            for (int axis = 0; axis < 3; ++axis) {
                const auto bin = static_cast<size_t>(binnings[axis](middle[axis]));
                extend(bins[axis].boxes[bin], items_[i].box);
                ++bins[axis].counts[bin];
            }
        }
        Split best;
        for (int axis = 0; axis < 3; ++axis)
            if (binnings[axis].scale > 0)
                consider(axis, bins[axis], static_cast<size_t>(binnings[axis].bins), half_area(box),
                         best);
        return best;
    }

    /// Sweeps over the bins from both ends.
    void consider(int axis, const Bins& bins, size_t bin_count, float area, Split& best) const {
        std::array<float, most_bins> right_cost;
        Box3 box;
        uint32_t count = 0;
        for (size_t i = bin_count - 1; i > 0; --i) {
            extend(box, bins.boxes[i]);
            count += bins.counts[i];
            right_cost[i] = half_area(box) * units(count);
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
                (area > 0 ? (half_area(box) * units(count) + right_cost[i]) / area : 0);
            if (cost < best.cost) best = {cost, axis, static_cast<int>(i)};
        }
    }

    uint32_t partition(uint32_t begin, uint32_t end, const Box3& centres, const Split& split) {
        const Binning binning(centres, split.axis, end - begin);
        const auto middle = std::partition(
            items_.begin() + begin, items_.begin() + end,
            [&](const Item& item) { return binning(centre(item.box)[split.axis]) < split.bin; });
        return static_cast<uint32_t>(middle - items_.begin());
    }

    uint32_t halve(uint32_t begin, uint32_t end, const Box3& centres) {
        const auto axis = static_cast<int>(centres.majorAxis());
        const uint32_t middle = begin + (end - begin) / 2;
        std::nth_element(items_.begin() + begin, items_.begin() + middle, items_.begin() + end,
                         [&](const Item& a, const Item& b) {
                             const float x = centre(a.box)[axis], y = centre(b.box)[axis];
                             return x != y ? x < y : a.index < b.index;
                         });
        return middle;
    }

    /// Turns the binary tree below `index` into nodes of eight: the child with the largest box is
    /// replaced by its children until eight are there.
    TreeLink collapse(uint32_t index, BoxTree& tree) const {
        const BinaryNode& node = nodes_[index];
        if (node.is_leaf()) {
            const uint32_t first = tree.units, count = (node.end - node.begin + unit_ - 1) / unit_;
            const auto begin = static_cast<uint32_t>(tree.order.size());
            for (uint32_t i = node.begin; i < node.end; ++i) tree.order.push_back(items_[i].index);
            tree.leaves.push_back({begin, static_cast<uint32_t>(tree.order.size())});
            tree.units += count;
            return TreeLink::leaf(first, count);
        }
        std::vector<uint32_t> children = {node.left, node.right};
        while (children.size() < 8) {
            const auto area = [&](uint32_t child) {
                return nodes_[child].is_leaf() ? -1 : half_area(nodes_[child].box);
            };
            const auto largest =
                std::max_element(children.begin(), children.end(),
                                 [&](uint32_t a, uint32_t b) { return area(a) < area(b); });
            if (nodes_[*largest].is_leaf()) break;
            const BinaryNode& opened = nodes_[*largest];
            *largest = opened.left;
            children.push_back(opened.right);
        }
        const auto place = static_cast<uint32_t>(tree.nodes.size());
        tree.nodes.push_back(boxes_of(children));
        for (size_t i = 0; i < children.size(); ++i) {
            const TreeLink link = collapse(children[i], tree);
            tree.nodes[place].links[i] = link;
        }
        return TreeLink::node(place);
    }

    WideNode boxes_of(const std::vector<uint32_t>& children) const {
        WideNode wide;
        std::fill_n(wide.links, 8, TreeLink::nothing());
        for (size_t i = 0; i < 8; ++i)
            for (int axis = 0; axis < 3; ++axis) {
                // An empty box must stay one after multiplying by a number of either sign.
                const bool used = i < children.size();
                wide.planes[2 * axis][i] =
                    used ? nodes_[children[i]].box.min[axis] : std::numeric_limits<float>::max();
                wide.planes[2 * axis + 1][i] =
                    used ? nodes_[children[i]].box.max[axis] : -std::numeric_limits<float>::max();
            }
        return wide;
    }

    uint32_t unit_;
    std::vector<Item> items_;
    std::vector<BinaryNode> nodes_;
};

}  // namespace

BoxTree build_tree(std::span<const Box3> boxes, uint32_t unit) {
    return Builder(boxes, unit).build();
}

}  // namespace sightline
