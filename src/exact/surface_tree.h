#pragma once
// Bounds of all surfaces of a scene, for the referee. Private to src/exact.
#include "exact/surface_id.h"
#include "exact/triangle.h"
#include "scene/scene.h"

#include <algorithm>
#include <vector>

namespace sightline {

/// A hierarchy over boxes, halved at the median.
class BoxTree {
  public:
    /// Bounds the items at first … first + count − 1 of `order`. A node of more than `leaf_size`
    /// items has two children: the next node and second().
    struct Node {
        Box3 box;
        uint32_t first, count;
    };
    static constexpr uint32_t leaf_size = 8;

    std::vector<Node> nodes;
    std::vector<uint32_t> order;  ///< indices of the boxes that are not empty

    BoxTree() = default;
    explicit BoxTree(std::vector<Box3> boxes);

    uint32_t second(uint32_t node) const { return node + 2 * (leaves_of(nodes[node].count) / 2); }

  private:
    static uint32_t leaves_of(uint32_t count) { return (count + leaf_size - 1) / leaf_size; }
    void build(uint32_t node, const std::vector<Box3>& boxes);
};

/// Conservative bounds of the surfaces of a scene: a tree over what is stored in world space, all
/// shapes and the instances, and one in object space for each group of meshes that is instanced.
/// Triangles with a coordinate that is not finite are left out.
class SurfaceTree {
  public:
    /// The scene must outlive the tree. Takes 12 bytes for each stored triangle, and at most 40
    /// while it is built.
    explicit SurfaceTree(const Scene& scene);

    /// Calls visit(id) for the surfaces that the ray may hit before `tmax`, which visit may lower,
    /// until it returns false.
    template <class Visit>
    void search(const Ray& ray, const double& tmax, const Visit& visit) const;

  private:
    /// Items of a tree from number `first` on: the triangles of a mesh, a shape, or an instance.
    struct Range {
        uint32_t first;
        SurfaceId surface;  ///< of the first item; without an instance in the tree of a group
        bool is_instance = false;
    };
    struct Level {
        BoxTree tree;
        std::vector<Range> ranges;
    };
    /// A node to be visited.
    struct Entry {
        const Level* level;
        uint32_t node;
        uint32_t instance;  ///< of the level; none in world space
    };
    class Builder;

    static const Range& range_of(const std::vector<Range>& ranges, uint32_t item) {
        return std::upper_bound(
            ranges.begin(), ranges.end(), item,
            [](uint32_t number, const Range& range) { return number < range.first; })[-1];
    }
    bool may_enter(const Ray& ray, double tmax, const Entry& entry) const;
    void push_children(const Ray& ray, const Entry& entry, std::vector<Entry>& stack) const;

    const Scene* scene_;
    Level world_;
    std::vector<Level> groups_;  // by group; empty unless it is instanced
};

template <class Visit>
void SurfaceTree::search(const Ray& ray, const double& tmax, const Visit& visit) const {
    if (world_.tree.nodes.empty() || !has_exact_answer(ray)) return;
    std::vector<Entry> stack = {{&world_, 0, none}};
    while (!stack.empty()) {
        const Entry entry = stack.back();
        stack.pop_back();
        if (!may_enter(ray, tmax, entry)) continue;
        const auto& [tree, ranges] = *entry.level;
        const BoxTree::Node& node = tree.nodes[entry.node];
        if (node.count > BoxTree::leaf_size) {
            push_children(ray, entry, stack);
            continue;
        }
        for (uint32_t i = node.first; i < node.first + node.count; ++i) {
            const uint32_t item = tree.order[i];
            const Range& range = range_of(ranges, item);
            SurfaceId id = range.surface;
            if (range.is_instance) {
                const uint32_t group = scene_->instances[id.instance].group;
                stack.push_back({&groups_[group], 0, id.instance});
                continue;
            }
            if (entry.instance != none) id.instance = entry.instance;
            id.primitive += item - range.first;
            if (!visit(id)) return;
        }
    }
}

}  // namespace sightline
