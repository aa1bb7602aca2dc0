#include "intersect/exact/two_level_bvh.h"

#include "core/memory.h"
#include "exact/bounded.h"
#include "intersect/bvh/spatial_splits.h"
#include "intersect/embree/build_quality.h"
#include "intersect/intersector.h"
#include "intersect/shapes.h"

#include <algorithm>

namespace sightline {
namespace {

/// Beyond this, float arithmetic might overflow.
constexpr float max_coordinate = 0x1p60f;
/// A matrix whose inverse in double precision is worse than this is not used to transform rays.
constexpr double max_residual = 0x1p-20;
/// Nor is a matrix that stretches or squeezes more: products in object space might overflow, or
/// lose all digits.
constexpr double max_stretch = 0x1p40;

/// Of taking a ray to an instance, in tests of two child boxes.
constexpr float object_cost = 16;

enum class TriangleSize { usable, huge, not_finite };

TriangleSize size_of(const InstancedTriangle& triangle) {
    TriangleSize size = TriangleSize::usable;
    for (const Vec3* v : {&triangle.a, &triangle.b, &triangle.c})
        for (int i = 0; i < 3; ++i) {
            if (!std::isfinite((*v)[i])) return TriangleSize::not_finite;
            if (std::abs((*v)[i]) > max_coordinate) size = TriangleSize::huge;
        }
    return size;
}

/// The inverse of an affine matrix in double precision, with its residual.
WorldToObject invert(const Mat4& m) {
    Vec3d rows[4];
    for (int i = 0; i < 4; ++i) rows[i] = Vec3d(Vec3(m[i][0], m[i][1], m[i][2]));
    Vec3d columns[] = {cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])};
    const double determinant = dot(rows[0], columns[0]);
    WorldToObject inverse;
    for (int j = 0; j < 3; ++j) {
        columns[j] /= determinant;
        for (int i = 0; i < 3; ++i) inverse.linear[i][j] = columns[j][i];
    }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const double product = dot(rows[i], columns[j]) - (i == j ? 1 : 0);
            const Vec3d sizes(std::abs(rows[i].x * columns[j].x),
                              std::abs(rows[i].y * columns[j].y),
                              std::abs(rows[i].z * columns[j].z));
            // A sum, so that a NaN shows.
            inverse.residual += std::abs(product) + 0x1p-50 * (sizes.x + sizes.y + sizes.z + 1);
        }
    inverse.translation = rows[3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            inverse.row_sizes[i] = std::max(inverse.row_sizes[i], std::abs(inverse.linear[i][j]));
    return inverse;
}

bool is_moderate(const Mat4& object_to_world, const WorldToObject& inverse) {
    double largest = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            largest = std::max({largest, std::abs(exact_double(object_to_world[i][j])),
                                std::abs(inverse.linear[i][j])});
    return largest < max_stretch;
}

std::vector<WorldToObject> invert_instances(const Scene& scene) {
    std::vector<WorldToObject> inverses(scene.instances.size());
    for (size_t i = 0; i < inverses.size(); ++i)
        if (!scene.instances[i].baked) inverses[i] = invert(scene.instances[i].object_to_world);
    return inverses;
}

std::vector<uint8_t> find_translucent(const Scene& scene) {
    std::vector<uint8_t> translucent;
    for (uint32_t geometry = 0; geometry < scene.meshes.size() + scene.shapes.size(); ++geometry)
        translucent.push_back(scene.material_of(geometry) < scene.materials.size() &&
                              is_translucent(scene.materials[scene.material_of(geometry)]));
    return translucent;
}

float norm1(const Vec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

Vec3 difference(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

/// Collects meshes and builds one BVH over them.
class MeshBvhBuilder {
  public:
    explicit MeshBvhBuilder(const Scene& scene) : scene_(scene) {}

    /// Adds the triangles of usable size and lists the huge ones.
    void add(uint32_t geometry, uint32_t instance) {
        const Mesh& mesh = scene_.meshes[geometry];
        result_.meshes.push_back({geometry, instance, count_});
        for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
            const auto& c = mesh.triangles[i];
            const InstancedTriangle triangle = {mesh.positions[c[0]], mesh.positions[c[1]],
                                                mesh.positions[c[2]]};
            const TriangleSize size = size_of(triangle);
            if (size == TriangleSize::huge) huge_.push_back({instance, geometry, i});
            if (size != TriangleSize::usable) continue;
            Box3 box(triangle.a);
            box.extendBy(triangle.b);
            box.extendBy(triangle.c);
            boxes_.push_back(box);
            numbers_.push_back(count_ + i);
            overlap_.add(triangle.a, triangle.b, triangle.c);
        }
        count_ += static_cast<uint32_t>(mesh.triangles.size());
    }

    /// The triangles left out of the BVH.
    const std::vector<SurfaceId>& huge() const { return huge_; }

    MeshBvh build(bool may_split) && {
        if (may_split && spatial_splits_pay_off(overlap_.stats()))
            split_boxes(boxes_, numbers_, [&](uint32_t number) { return corners(number); });
        Bvh& bvh = result_.triangles.bvh;
        bvh = build_bvh(boxes_, 8);
        boxes_ = {};
        reserve_in_large_pages(result_.triangles.blocks, bvh.blocks);
        for (const Bvh::Leaf& leaf : bvh.leaves)
            for (uint32_t i = leaf.begin; i < leaf.end; i += 8)
                add_block(std::span(bvh.order).subspan(i, std::min(8u, leaf.end - i)));
        bvh.leaves = {};
        bvh.order = {};
        return std::move(result_);
    }

  private:
    Corners<float> corners(uint32_t number) const {
        const SurfaceId id = result_.surface(number);
        const Mesh& mesh = scene_.meshes[id.geometry];
        const auto& [a, b, c] = mesh.triangles[id.primitive];
        return {mesh.positions[a], mesh.positions[b], mesh.positions[c]};
    }

    void add_block(std::span<const uint32_t> indices) {
        TriangleBvh& triangles = result_.triangles;
        TriangleBlock& block = triangles.blocks.emplace_back();
        for (size_t lane = 0; lane < 8; ++lane) {
            const uint32_t number = numbers_[indices[std::min(lane, indices.size() - 1)]];
            const Corners<float> triangle = corners(number);
            const Vec3 ab = difference(triangle.b, triangle.a);
            const Vec3 ac = difference(triangle.c, triangle.a);
            for (int i = 0; i < 3; ++i) {
                block.a[i][lane] = triangle.a[i];
                block.ab[i][lane] = ab[i];
                block.ac[i][lane] = ac[i];
            }
            block.triangle[lane] = number;
            triangles.max_edge = std::max(
                {triangles.max_edge, norm1(ab) * (1 + 0x1p-20f), norm1(ac) * (1 + 0x1p-20f)});
        }
    }

    const Scene& scene_;
    MeshBvh result_;
    uint32_t count_ = 0;
    std::vector<Box3> boxes_;
    std::vector<uint32_t> numbers_;  // of the triangles in the boxes
    OverlapCounter overlap_;
    std::vector<SurfaceId> huge_;
};

/// A float box around the transformed box.
Box3 transform_bounds(const Box3& box, const Mat4& m) {
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

/// The leaves of the upper level, and the triangles that no box bounds.
struct UpperLevel {
    std::vector<BvhObject> objects;
    std::vector<Box3> boxes;  // of the objects
    std::vector<SurfaceId> unbounded;

    void add(const BvhObject& object, const Box3& box) {
        objects.push_back(object);
        boxes.push_back(box);
    }
};

/// Adds each triangle of an instance whose matrix or its inverse cannot be used as an object of its
/// own.
void add_single_triangles(const TwoLevelBvh& bvh, uint32_t instance, UpperLevel& upper) {
    for (const uint32_t mesh : bvh.scene.groups[bvh.scene.instances[instance].group].meshes)
        for (uint32_t i = 0; i < bvh.scene.meshes[mesh].triangles.size(); ++i) {
            const SurfaceId id{instance, mesh, i};
            const InstancedTriangle triangle = bvh.triangle(id);
            const TriangleSize size = size_of(triangle);
            if (size == TriangleSize::huge) upper.unbounded.push_back(id);
            if (size == TriangleSize::usable)
                upper.add({BvhObject::Kind::triangle, instance, mesh, i}, exact_bounds(triangle));
        }
}

void add_shapes(const Scene& scene, uint32_t index, UpperLevel& upper) {
    const Instance& instance = scene.instances[index];
    const Mat4 to_world = instance.baked ? Mat4() : instance.object_to_world;
    const auto first_shape = static_cast<uint32_t>(scene.meshes.size());
    for (const uint32_t shape : scene.groups[instance.group].shapes)
        upper.add({BvhObject::Kind::shape, index, first_shape + shape},
                  transform_bounds(shape_bounds(scene.shapes[shape]), to_world));
}

/// Appends boxes that together bound what is below a node: those of its descendants after `levels`
/// levels.
void append_boxes(const Bvh& bvh, NodeRef node, const Box3& bounds, int levels,
                  std::vector<Box3>& boxes) {
    if (node.is_nothing()) return;
    if (node.is_leaf() || levels == 0) {
        boxes.push_back(bounds);
        return;
    }
    const BvhNode& inner = bvh.nodes[node.index()];
    for (size_t i = 0; i < 8; ++i) {
        const auto& p = inner.planes;
        const Box3 child({p[0][i], p[2][i], p[4][i]}, {p[1][i], p[3][i], p[5][i]});
        append_boxes(bvh, inner.children[i], child, levels - 1, boxes);
    }
}

/// The BVHs of instanced groups, each built at its first use.
class GroupBvhs {
  public:
    GroupBvhs(const Scene& scene, bool may_split)
        : scene_(scene), may_split_(may_split), indices_(scene.groups.size(), none) {}

    /// Adds an instance of its group's BVH.
    void add_instance(uint32_t instance, UpperLevel& upper) {
        const uint32_t index = find(scene_.instances[instance].group);
        for (SurfaceId id : huge_[index]) {
            id.instance = instance;
            upper.unbounded.push_back(id);
        }
        // The boxes of parts, turned, are smaller than that of the whole.
        Box3 box;
        for (const Box3& part : parts_[index])
            box.extendBy(transform_bounds(part, scene_.instances[instance].object_to_world));
        if (!box.isEmpty()) upper.add({BvhObject::Kind::meshes, instance, index}, box);
    }

    std::vector<MeshBvh> take() && { return std::move(bvhs_); }

  private:
    uint32_t find(uint32_t group) {
        if (indices_[group] != none) return indices_[group];
        MeshBvhBuilder builder(scene_);
        for (const uint32_t mesh : scene_.groups[group].meshes) builder.add(mesh, none);
        huge_.push_back(builder.huge());
        bvhs_.push_back(std::move(builder).build(may_split_));
        const Bvh& bvh = bvhs_.back().triangles.bvh;
        append_boxes(bvh, bvh.root, bvh.bounds, 2, parts_.emplace_back());
        return indices_[group] = static_cast<uint32_t>(bvhs_.size() - 1);
    }

    const Scene& scene_;
    bool may_split_;
    std::vector<uint32_t> indices_;  // by group
    std::vector<MeshBvh> bvhs_;
    std::vector<std::vector<SurfaceId>> huge_;  // by BVH
    std::vector<std::vector<Box3>> parts_;      // by BVH
};

}  // namespace

LocalRay WorldToObject::transform(const Vec3& origin, const Vec3& direction, float tnear) const {
    // Origin and direction side by side.
    using Pair = double __attribute__((vector_size(16)));
    using Bits = int64_t __attribute__((vector_size(16)));
    const auto abs = [](Pair x) { return std::bit_cast<Pair>(std::bit_cast<Bits>(x) & INT64_MAX); };
    Pair v[3], to[3];
    for (int i = 0; i < 3; ++i)
        v[i] = Pair{double(origin[i]) - translation[i], double(direction[i])};
    for (int j = 0; j < 3; ++j)
        to[j] = v[0] * linear[0][j] + v[1] * linear[1][j] + v[2] * linear[2][j];
    // Bounds the error of rounding `to` to double and to floats, and that of the inverse; as a
    // float above it, also below the normal floats.
    const Pair rounding = 0x1p-49 * (abs(v[0]) * row_sizes.x + abs(v[1]) * row_sizes.y +
                                     abs(v[2]) * row_sizes.z),
               size = abs(to[0]) + abs(to[1]) + abs(to[2]);
    const Pair error =
        (rounding + (2 * residual + 0x1p-24) * size) * ((1 + 0x1p-20) * (1 + 0x1p-22));
    const auto above = [](double x) { return x > 0 ? static_cast<float>(x) + 0x1p-148f : 0.0f; };
    const auto lane = [&](size_t i) {
        return Vec3(static_cast<float>(to[0][i]), static_cast<float>(to[1][i]),
                    static_cast<float>(to[2][i]));
    };
    return {lane(0), lane(1), tnear, above(error[0]), above(error[1])};
}

TwoLevelBvh::TwoLevelBvh(const Scene& s, bool may_split)
    : scene(s), world_to_object(invert_instances(s)), translucent(find_translucent(s)) {
    MeshBvhBuilder baked_meshes(s);
    GroupBvhs group_bvhs(s, may_split);
    UpperLevel upper;
    for (uint32_t i = 0; i < s.instances.size(); ++i) {
        const Instance& instance = s.instances[i];
        if (!instance.baked && !is_finite(instance.object_to_world)) continue;
        const bool invertible = instance.baked || world_to_object[i].residual < max_residual;
        if (invertible) add_shapes(s, i, upper);
        if (instance.baked)
            for (const uint32_t mesh : s.groups[instance.group].meshes) baked_meshes.add(mesh, i);
        else if (invertible && is_moderate(instance.object_to_world, world_to_object[i]))
            group_bvhs.add_instance(i, upper);
        else
            add_single_triangles(*this, i, upper);
    }
    unbounded = std::move(upper.unbounded);
    unbounded.insert(unbounded.end(), baked_meshes.huge().begin(), baked_meshes.huge().end());
    groups = std::move(group_bvhs).take();
    baked = std::move(baked_meshes).build(may_split);
    object_bvh = build_bvh(upper.boxes, 1, object_cost);
    for (const uint32_t i : object_bvh.order) objects.push_back(upper.objects[i]);
}

size_t TwoLevelBvh::memory() const {
    const auto bytes = [](const MeshBvh& mesh) {
        return mesh.triangles.bvh.nodes.size() * sizeof(BvhNode) +
               mesh.triangles.blocks.size() * sizeof(TriangleBlock);
    };
    size_t sum = bytes(baked) + object_bvh.nodes.size() * sizeof(BvhNode) +
                 objects.size() * sizeof(BvhObject) +
                 world_to_object.size() * sizeof(WorldToObject);
    for (const MeshBvh& group : groups) sum += bytes(group);
    return sum;
}

}  // namespace sightline
