#include "exact/surface_tree.h"

#include "core/parallel.h"
#include "exact/bounded.h"
#include "exact/shapes.h"

#include <algorithm>

namespace sightline {
namespace {

/// Items that are halved by two threads.
constexpr uint32_t parallel_from = 1 << 16;

struct DoubleBox {
    Vec3d min, max;
};

/// A box around the transformed box. Products of floats are exact in double, and sums of four are
/// off by less than four units of rounding.
DoubleBox transformed(const Box3& box, const Mat4& m) {
    DoubleBox result;
    for (int j = 0; j < 3; ++j) {
        double low = exact_double(m[3][j]), high = low, size = std::abs(low);
        for (int i = 0; i < 3; ++i) {
            const double factor = exact_double(m[i][j]);
            const double a = exact_double(box.min[i]) * factor,
                         b = exact_double(box.max[i]) * factor;
            low += std::min(a, b);
            high += std::max(a, b);
            size += std::max(std::abs(a), std::abs(b));
        }
        result.min[j] = low - size * 0x1p-50;
        result.max[j] = high + size * 0x1p-50;
    }
    return result;
}

DoubleBox in_double(const Box3& box) {
    return {{exact_double(box.min.x), exact_double(box.min.y), exact_double(box.min.z)},
            {exact_double(box.max.x), exact_double(box.max.y), exact_double(box.max.z)}};
}

Box3 in_floats(const DoubleBox& box) {
    return {{float_below(box.min.x), float_below(box.min.y), float_below(box.min.z)},
            {float_above(box.max.x), float_above(box.max.y), float_above(box.max.z)}};
}

float centre(const Box3& box, int axis) {
    const bool unbounded = std::isinf(box.min[axis]);
    return unbounded ? 0 : box.min[axis] * 0.5f + box.max[axis] * 0.5f;
}

}  // namespace

BoxTree::BoxTree(std::vector<Box3> boxes) {
    order.reserve(boxes.size());
    for (uint32_t i = 0; i < boxes.size(); ++i)
        if (!boxes[i].isEmpty()) order.push_back(i);
    if (order.empty()) return;
    const auto count = static_cast<uint32_t>(order.size());
    nodes.resize(2 * size_t{leaves_of(count)} - 1);
    nodes[0].first = 0;
    nodes[0].count = count;
    build(0, boxes);
}

void BoxTree::build(uint32_t index, const std::vector<Box3>& boxes) {
    Node& node = nodes[index];
    const auto items = std::span(order).subspan(node.first, node.count);
    if (node.count <= leaf_size) {
        for (const uint32_t i : items) node.box.extendBy(boxes[i]);
        return;
    }
    Box3 centres;
    for (const uint32_t i : items)
        centres.extendBy({centre(boxes[i], 0), centre(boxes[i], 1), centre(boxes[i], 2)});
    const auto axis = static_cast<int>(centres.majorAxis());
    const uint32_t half = leaves_of(node.count) / 2 * leaf_size;
    std::nth_element(items.begin(), items.begin() + half, items.end(), [&](uint32_t a, uint32_t b) {
        return centre(boxes[a], axis) < centre(boxes[b], axis);
    });
    const std::array<uint32_t, 2> children = {index + 1, second(index)};
    nodes[children[0]].first = node.first;
    nodes[children[0]].count = half;
    nodes[children[1]].first = node.first + half;
    nodes[children[1]].count = node.count - half;
    if (node.count >= parallel_from)
        parallel_for(2, [&](size_t i) { build(children[i], boxes); });
    else
        for (const uint32_t child : children) build(child, boxes);
    for (const uint32_t child : children) node.box.extendBy(nodes[child].box);
}

/// Collects the items of a level.
class SurfaceTree::Builder {
  public:
    explicit Builder(const Scene& scene) : scene_(scene) {}

    /// The triangles of a mesh in the space of its vertices.
    void add_mesh(uint32_t instance, uint32_t mesh) {
        const Mesh& from = scene_.meshes[mesh];
        ranges_.push_back({next(), {instance, mesh, 0}});
        for (const auto& [a, b, c] : from.triangles) {
            const Vec3 &p = from.positions[a], &q = from.positions[b], &r = from.positions[c];
            Box3& box = boxes_.emplace_back();
            if (!is_finite({p, q, r})) continue;
            box.extendBy(p);
            box.extendBy(q);
            box.extendBy(r);
        }
    }

    void add_item(const SurfaceId& surface, bool is_instance, const Box3& box) {
        ranges_.push_back({next(), surface, is_instance});
        boxes_.push_back(box);
    }

    Level build() && { return {BoxTree(std::move(boxes_)), std::move(ranges_)}; }

  private:
    uint32_t next() const { return static_cast<uint32_t>(boxes_.size()); }

    const Scene& scene_;
    std::vector<Box3> boxes_;
    std::vector<Range> ranges_;
};

SurfaceTree::SurfaceTree(const Scene& scene) : scene_(&scene), groups_(scene.groups.size()) {
    Builder world(scene);
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const Group& group = scene.groups[instance.group];
        const Mat4* to_world = instance.baked ? nullptr : &instance.object_to_world;
        for (const uint32_t shape : group.shapes) {
            const auto geometry = static_cast<uint32_t>(scene.meshes.size()) + shape;
            world.add_item({i, geometry, 0}, false, exact_bounds({&scene.shapes[shape], to_world}));
        }
        if (instance.baked) {
            for (const uint32_t mesh : group.meshes) world.add_mesh(i, mesh);
            continue;
        }
        Level& level = groups_[instance.group];
        if (level.ranges.empty()) {
            Builder meshes(scene);
            for (const uint32_t mesh : group.meshes) meshes.add_mesh(none, mesh);
            level = std::move(meshes).build();
        }
        if (level.tree.nodes.empty() || !is_finite(*to_world)) continue;
        world.add_item({i, none, 0}, true,
                       in_floats(transformed(level.tree.nodes[0].box, *to_world)));
    }
    world_ = std::move(world).build();
}

/// Conservative: true if the ray up to tmax might have a point in common with the node's box.
bool SurfaceTree::may_enter(const Ray& ray, double tmax, const Entry& entry) const {
    const Box3& stored = entry.level->tree.nodes[entry.node].box;
    const DoubleBox box =
        entry.instance == none
            ? in_double(stored)
            : transformed(stored, scene_->instances[entry.instance].object_to_world);
    double near = exact_double(ray.tnear), far = tmax;
    for (int i = 0; i < 3; ++i) {
        const double o = exact_double(ray.origin[i]), d = exact_double(ray.direction[i]);
        const double low = box.min[i] - o, high = box.max[i] - o;
        if (d == 0) {
            if (low > 0 || high < 0) return false;
            continue;
        }
        const double entry_t = (d > 0 ? low : high) / d, exit_t = (d > 0 ? high : low) / d;
        near = std::max(near, entry_t - std::abs(entry_t) * 0x1p-50);
        far = std::min(far, exit_t + std::abs(exit_t) * 0x1p-50);
    }
    return near <= far;
}

/// The nearer one last.
void SurfaceTree::push_children(const Ray& ray, const Entry& entry,
                                std::vector<Entry>& stack) const {
    const BoxTree& tree = entry.level->tree;
    Entry first = entry, second = entry;
    ++first.node;
    second.node = tree.second(entry.node);
    Vec3 between = tree.nodes[first.node].box.center() - tree.nodes[second.node].box.center();
    if (entry.instance != none)
        scene_->instances[entry.instance].object_to_world.multDirMatrix(between, between);
    const bool first_is_nearer = dot(ray.direction, between) <= 0;
    stack.push_back(first_is_nearer ? second : first);
    stack.push_back(first_is_nearer ? first : second);
}

}  // namespace sightline
