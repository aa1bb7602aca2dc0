#include "intersect/exact/two_level_bvh.h"

#include "core/pages.h"
#include "exact/bounded.h"
#include "intersect/bvh/spatial_splits.h"
#include "intersect/embree/build_quality.h"
#include "intersect/intersector.h"
#include "intersect/shapes.h"

#include <algorithm>

namespace sightline {
namespace {

/// Beyond this float arithmetic might overflow.
constexpr float largest_coordinate = 0x1p60f;
/// A matrix whose inverse in double is worse than this is not used to move rays.
constexpr double largest_residual = 0x1p-20;

enum class Size { usable, huge, broken };

Size size_of(const PlacedTriangle& triangle) {
    Size size = Size::usable;
    for (const Vec3* v : {&triangle.a, &triangle.b, &triangle.c})
        for (int i = 0; i < 3; ++i) {
            if (!std::isfinite((*v)[i])) return Size::broken;
            if (std::abs((*v)[i]) > largest_coordinate) size = Size::huge;
        }
    return size;
}

bool is_finite(const Mat4& m) {
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            if (!std::isfinite(m[i][j])) return false;
    return true;
}

/// The inverse of an affine matrix in double, and how far it is from one.
Entry inverse_of(const Mat4& m) {
    Vec3d rows[4];
    for (int i = 0; i < 4; ++i) rows[i] = Vec3d(Vec3(m[i][0], m[i][1], m[i][2]));
    Vec3d columns[] = {cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])};
    const double determinant = dot(rows[0], columns[0]);
    Entry entry;
    for (int j = 0; j < 3; ++j) {
        columns[j] /= determinant;
        for (int i = 0; i < 3; ++i) entry.from_world[i][j] = columns[j][i];
    }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const double product = dot(rows[i], columns[j]) - (i == j ? 1 : 0);
            const Vec3d sizes(std::abs(rows[i].x * columns[j].x),
                              std::abs(rows[i].y * columns[j].y),
                              std::abs(rows[i].z * columns[j].z));
            // A sum, so that one that is not a number shows.
            entry.residual += std::abs(product) + 0x1p-50 * (sizes.x + sizes.y + sizes.z + 1);
        }
    entry.translation = rows[3];
    return entry;
}

float norm1(const Vec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

Vec3 difference(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

/// Triangles on their way into a tree.
class Gathering {
  public:
    /// Adds the triangles of usable size and lists the huge ones.
    void add(const Scene& scene, uint32_t geometry, uint32_t instance,
             std::vector<SurfaceId>& huge) {
        const Mesh& mesh = scene.meshes[geometry];
        result_.parts.push_back({geometry, instance, count_});
        for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
            const auto& c = mesh.triangles[i];
            const PlacedTriangle triangle = {mesh.positions[c[0]], mesh.positions[c[1]],
                                             mesh.positions[c[2]]};
            const Size size = size_of(triangle);
            if (size == Size::huge) huge.push_back({instance, geometry, i});
            if (size != Size::usable) continue;
            Box3 box(triangle.a);
            box.extendBy(triangle.b);
            box.extendBy(triangle.c);
            boxes_.push_back(box);
            numbers_.push_back(count_ + i);
            waste_.add(triangle.a, triangle.b, triangle.c);
        }
        count_ += static_cast<uint32_t>(mesh.triangles.size());
    }

    /// What has been added, in a tree.
    MeshTree tree(const Scene& scene, bool may_split) && {
        if (may_split && splits_pay(waste_.waste()))
            split_boxes(boxes_, numbers_, [&](uint32_t number) { return corners(number, scene); });
        TriangleTree& tree = result_.tree;
        tree.boxes = build_tree(boxes_, 8);
        boxes_ = {};
        reserve_in_large_pages(tree.blocks, tree.boxes.units);
        for (const BoxTree::Leaf& leaf : tree.boxes.leaves)
            for (uint32_t i = leaf.begin; i < leaf.end; i += 8)
                add_block(std::span(tree.boxes.order).subspan(i, std::min(8u, leaf.end - i)),
                          scene);
        tree.boxes.leaves = {};
        tree.boxes.order = {};
        return std::move(result_);
    }

  private:
    Corners<float> corners(uint32_t number, const Scene& scene) const {
        const SurfaceId id = result_.surface(number);
        const Mesh& mesh = scene.meshes[id.geometry];
        const auto& [a, b, c] = mesh.triangles[id.primitive];
        return {mesh.positions[a], mesh.positions[b], mesh.positions[c]};
    }

    void add_block(std::span<const uint32_t> indices, const Scene& scene) {
        TriangleTree& tree = result_.tree;
        TriangleBlock& block = tree.blocks.emplace_back();
        for (size_t lane = 0; lane < 8; ++lane) {
            const uint32_t number = numbers_[indices[std::min(lane, indices.size() - 1)]];
            const Corners<float> triangle = corners(number, scene);
            const Vec3 ab = difference(triangle.b, triangle.a);
            const Vec3 ac = difference(triangle.c, triangle.a);
            for (int i = 0; i < 3; ++i) {
                block.a[i][lane] = triangle.a[i];
                block.ab[i][lane] = ab[i];
                block.ac[i][lane] = ac[i];
            }
            block.triangle[lane] = number;
            tree.largest_edge = std::max(
                {tree.largest_edge, norm1(ab) * (1 + 0x1p-20f), norm1(ac) * (1 + 0x1p-20f)});
        }
    }

    MeshTree result_;
    uint32_t count_ = 0;
    std::vector<Box3> boxes_;
    std::vector<uint32_t> numbers_;  ///< of the triangles that the boxes are around
    WasteTally waste_;
};

/// A box of floats around a box of one space in another.
Box3 moved(const Box3& box, const Mat4& m) {
    Box3 result;
    for (int corner = 0; corner < 8; ++corner)
        for (int j = 0; j < 3; ++j) {
            double x = static_cast<double>(m[3][j]), size = std::abs(x);
            for (int i = 0; i < 3; ++i) {
                const float p = corner >> i & 1 ? box.max[i] : box.min[i];
                const double term = static_cast<double>(p) * static_cast<double>(m[i][j]);
                x += term;
                size += std::abs(term);
            }
            result.min[j] = std::min(result.min[j], float_below(x - size * 0x1p-50));
            result.max[j] = std::max(result.max[j], float_above(x + size * 0x1p-50));
        }
    return result;
}

}  // namespace

LocalRay Entry::enter(const Vec3d& origin, const Vec3d& direction, float tnear) const {
    const Vec3d from = origin - translation;
    const auto multiply = [&](const Vec3d& v, double& rounding) {
        Vec3d result;
        for (int j = 0; j < 3; ++j) {
            double size = 0;
            for (int i = 0; i < 3; ++i) {
                result[j] = (i == 0 ? 0 : result[j]) + v[i] * from_world[i][j];
                size += std::abs(v[i] * from_world[i][j]);
            }
            rounding = std::max(rounding, size * 0x1p-49);
        }
        return result;
    };
    LocalRay ray;
    double origin_rounding = 0, direction_rounding = 0;
    const Vec3d o = multiply(from, origin_rounding), d = multiply(direction, direction_rounding);
    ray.origin = Vec3(o);
    ray.direction = Vec3(d);
    ray.tnear = tnear;
    const auto bound = [&](const Vec3d& v, double rounding) {
        const double size = std::abs(v.x) + std::abs(v.y) + std::abs(v.z);
        return float_above((rounding + 2 * residual * size + 0x1p-24 * size) * (1 + 0x1p-20));
    };
    ray.origin_error = bound(o, origin_rounding);
    ray.direction_error = bound(d, direction_rounding);
    return ray;
}

/// What the constructor gathers.
struct PlacedScene::Draft {
    Gathering baked;
    std::vector<Box3> object_boxes;
    std::vector<PlacedObject> objects;
    std::vector<std::vector<SurfaceId>> huge_of_tree;

    void add(const PlacedObject& object, const Box3& box) {
        objects.push_back(object);
        object_boxes.push_back(box);
    }
};

PlacedScene::PlacedScene(const Scene& s, bool may_split)
    : scene(s), entries(s.instances.size()), may_split_(may_split) {
    for (uint32_t geometry = 0; geometry < s.meshes.size() + s.shapes.size(); ++geometry)
        translucent.push_back(s.material_of(geometry) < s.materials.size() &&
                              is_translucent(s.materials[s.material_of(geometry)]));
    Draft draft;
    std::vector<uint32_t> tree_of_group(s.groups.size(), none);
    for (uint32_t i = 0; i < s.instances.size(); ++i) place(i, tree_of_group, draft);
    baked = std::move(draft.baked).tree(s, may_split);
    object_tree = build_tree(draft.object_boxes, 1);
    for (const uint32_t i : object_tree.order) objects.push_back(draft.objects[i]);
}

void PlacedScene::place(uint32_t index, std::vector<uint32_t>& tree_of_group, Draft& draft) {
    const Instance& instance = scene.instances[index];
    const Group& group = scene.groups[instance.group];
    const auto first_shape = static_cast<uint32_t>(scene.meshes.size());
    if (!instance.baked) {
        if (!is_finite(instance.object_to_world)) return;
        entries[index] = inverse_of(instance.object_to_world);
    }
    const bool enterable = instance.baked || entries[index].residual < largest_residual;
    const Mat4 to_world = instance.baked ? Mat4() : instance.object_to_world;
    if (enterable)
        for (const uint32_t shape : group.shapes)
            draft.add({PlacedObject::Kind::shape, index, first_shape + shape},
                      moved(shape_bounds(scene.shapes[shape]), to_world));
    if (instance.baked) {
        for (const uint32_t mesh : group.meshes) draft.baked.add(scene, mesh, index, unbounded);
        return;
    }
    if (!enterable) {
        for (const uint32_t mesh : group.meshes)
            for (uint32_t i = 0; i < scene.meshes[mesh].triangles.size(); ++i) {
                const PlacedTriangle flat = triangle({index, mesh, i});
                const Size size = size_of(flat);
                if (size == Size::huge) unbounded.push_back({index, mesh, i});
                if (size == Size::usable)
                    draft.add({PlacedObject::Kind::triangle, index, mesh, i}, exact_bounds(flat));
            }
        return;
    }
    uint32_t& tree = tree_of_group[instance.group];
    if (tree == none) {
        tree = static_cast<uint32_t>(groups.size());
        Gathering gathering;
        std::vector<SurfaceId> huge;
        for (const uint32_t mesh : group.meshes) gathering.add(scene, mesh, none, huge);
        groups.push_back(std::move(gathering).tree(scene, may_split_));
        draft.huge_of_tree.push_back(std::move(huge));
    }
    for (SurfaceId id : draft.huge_of_tree[tree]) {
        id.instance = index;
        unbounded.push_back(id);
    }
    const BoxTree& boxes = groups[tree].tree.boxes;
    if (!boxes.root.is_nothing())
        draft.add({PlacedObject::Kind::meshes, index, tree}, moved(boxes.bounds, to_world));
}

PlacedTriangle PlacedScene::triangle(const SurfaceId& id) const {
    const Mesh& mesh = scene.meshes[id.geometry];
    const auto& corners = mesh.triangles[id.primitive];
    const Instance& instance = scene.instances[id.instance];
    return {mesh.positions[corners[0]], mesh.positions[corners[1]], mesh.positions[corners[2]],
            instance.baked ? nullptr : &instance.object_to_world};
}

size_t PlacedScene::memory() const {
    const auto bytes = [](const MeshTree& mesh) {
        return mesh.tree.boxes.nodes.size() * sizeof(WideNode) +
               mesh.tree.blocks.size() * sizeof(TriangleBlock);
    };
    size_t sum = bytes(baked) + object_tree.nodes.size() * sizeof(WideNode) +
                 objects.size() * sizeof(PlacedObject) + entries.size() * sizeof(Entry);
    for (const MeshTree& group : groups) sum += bytes(group);
    return sum;
}

}  // namespace sightline
