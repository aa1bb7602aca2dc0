#include "intersect/methods/method_intersector.h"

#include "exact/arithmetic.h"
#include "exact/bounded.h"
#include "exact/referee.h"
#include "intersect/exact/hit_query.h"
#include "intersect/methods/boxes.h"
#include "intersect/ray_rules.h"
#include "intersect/shapes.h"

#include <algorithm>

namespace sightline {
namespace {

/// The triangles of a mesh, with a box around them.
struct MeshBounds {
    Box3 box;
    uint32_t first, count;
};

/// All triangles in world coordinates, rounded to floats, and all shapes; either the opaque or the
/// translucent ones.
struct FlatScene {
    std::vector<Corners<float>> triangles;
    std::vector<SurfaceId> ids;  // of the triangles
    std::vector<Box3> boxes;     // of the triangles
    std::vector<MeshBounds> meshes;
    std::vector<SurfaceId> shapes;

    FlatScene(const Scene& scene, bool translucent) {
        const auto is_included = [&](uint32_t geometry) {
            const uint32_t material = scene.material_of(geometry);
            return translucent ==
                   (material < scene.materials.size() && is_translucent(scene.materials[material]));
        };
        const auto first_shape = static_cast<uint32_t>(scene.meshes.size());
        for (uint32_t i = 0; i < scene.instances.size(); ++i) {
            const Group& group = scene.groups[scene.instances[i].group];
            for (const uint32_t mesh : group.meshes)
                if (is_included(mesh)) add(scene, i, mesh);
            for (const uint32_t shape : group.shapes)
                if (is_included(first_shape + shape)) shapes.push_back({i, first_shape + shape, 0});
        }
    }

    /// Moves triangle order[i] to position i.
    void reorder(const std::vector<uint32_t>& order) {
        std::vector<Corners<float>> sorted;
        std::vector<SurfaceId> sorted_ids;
        for (const uint32_t i : order) {
            sorted.push_back(triangles[i]);
            sorted_ids.push_back(ids[i]);
        }
        triangles = std::move(sorted);
        ids = std::move(sorted_ids);
    }

  private:
    void add(const Scene& scene, uint32_t index, uint32_t geometry) {
        const Mesh& mesh = scene.meshes[geometry];
        const Instance& instance = scene.instances[index];
        const auto to_world = [&](uint32_t vertex) {
            const Vec3& p = mesh.positions[vertex];
            return instance.baked ? p : transform_point(p, instance.object_to_world);
        };
        MeshBounds bounds{{}, static_cast<uint32_t>(ids.size()), 0};
        for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
            const auto& [a, b, c] = mesh.triangles[i];
            const Corners<float> triangle = {to_world(a), to_world(b), to_world(c)};
            Box3 box(triangle.a);
            box.extendBy(triangle.b);
            box.extendBy(triangle.c);
            const Vec3 s = triangle.a + triangle.b + triangle.c;
            if (!(std::abs(s.x) + std::abs(s.y) + std::abs(s.z) < 0x1p85f)) continue;
            triangles.push_back(triangle);
            ids.push_back({index, geometry, i});
            boxes.push_back(box);
            bounds.box.extendBy(box);
            ++bounds.count;
        }
        if (bounds.count > 0) meshes.push_back(bounds);
    }
};

/// The closest triangle of one ray. The traversal's t is the ray's t divided by a power of two.
class MethodQuery : public LeafVisitor {
  public:
    MethodQuery(const TriangleSet& set, const Ray& ray)
        : best{static_cast<double>(ray.tfar)},
          set_(set),
          ray_(ray),
          scale_(direction_scale(ray.direction)) {}

    /// The ray for a BVH.
    LocalRay traversal_ray() const {
        return {ray_.origin, Vec3(Vec3d(ray_.direction) * scale_),
                float_below(exact_double(ray_.tnear) / scale_)};
    }
    TraversalLimits initial_limits() const {
        TraversalLimits limits;
        limits.t_max = float_above(exact_double(ray_.tfar) / scale_);
        return limits;
    }
    /// The ray's own t beyond which nothing matters.
    double ray_t_max(const TraversalLimits& limits) const {
        return static_cast<double>(limits.t_max) * scale_;
    }

    bool on_leaf(uint32_t first, uint32_t count, TraversalLimits& limits) override {
        set_.nearest(ray_, first, count, best);
        // A little beyond, since the method's t and the box's are rounded differently.
        limits.t_max = std::min(limits.t_max, float_above(best.t / scale_ * (1 + 0x1p-20)));
        return false;
    }

    NearestTriangle best;

  private:
    const TriangleSet& set_;
    const Ray& ray_;
    double scale_;
};

/// One method over the opaque or the translucent part of a scene.
class MethodScene {
  public:
    MethodScene(const Scene& scene, bool translucent, const TriangleMethod& method,
                Structure structure)
        : scene_(scene), structure_(structure), flat_(scene, translucent) {
        if (structure == Structure::bvh) {
            bvh_ = build_bvh(flat_.boxes, 1);
            flat_.reorder(bvh_.order);
        }
        set_ = method.prepare(flat_.triangles);
        flat_.triangles = {};
        flat_.boxes = {};
    }

    /// Replaces `hit` if something is nearer.
    void find_closest(const Ray& ray, Hit& hit) const {
        Ray rest = ray;
        rest.tfar = std::min(ray.tfar, hit.t);
        const NearestTriangle best = closest_triangle(rest);
        if (best.index != none) {
            const SurfaceId& id = flat_.ids[best.index];
            hit = {static_cast<float>(best.t),
                   static_cast<float>(best.u),
                   static_cast<float>(best.v),
                   id.primitive,
                   id.geometry,
                   id.instance};
            rest.tfar = hit.t;
        }
        for (const SurfaceId& id : flat_.shapes) test_shape(id, rest, hit);
    }

    /// Appends the hits of ray number `index`.
    void find_all(const Ray& ray, uint32_t index, std::vector<RayHit>& hits) const {
        const auto add = [&](uint32_t triangle, const TriangleHit<double>& at) {
            const SurfaceId& id = flat_.ids[triangle];
            hits.push_back({index,
                            {static_cast<float>(at.t), static_cast<float>(at.u),
                             static_cast<float>(at.v), id.primitive, id.geometry, id.instance}});
        };
        for_each_hit(ray, add);
        for (const SurfaceId& id : flat_.shapes) {
            Ray segment = ray;
            Hit hit;
            test_shape(id, segment, hit);
            if (hit) hits.push_back({index, hit});
        }
    }

    size_t memory() const { return set_->memory() + bvh_.nodes.size() * sizeof(BvhNode); }

  private:
    NearestTriangle closest_triangle(const Ray& ray) const {
        MethodQuery query(*set_, ray);
        TraversalLimits limits = query.initial_limits();
        switch (structure_) {
            case Structure::loop:
                query.on_leaf(0, static_cast<uint32_t>(flat_.ids.size()), limits);
                break;
            case Structure::mesh_bounds:
                test_meshes(ray, query, limits);
                break;
            case Structure::bvh:
                if (!bvh_.root.is_nothing())
                    traverse(bvh_, TraversalRay(query.traversal_ray(), bvh_), limits, query);
        }
        return query.best;
    }

    template <class Add>
    void for_each_hit(const Ray& ray, const Add& add) const {
        struct Visitor : LeafVisitor {
            Visitor(const TriangleSet& from, const Ray& along, const Add& to)
                : set(from), ray(along), add(to) {}
            bool on_leaf(uint32_t first, uint32_t count, TraversalLimits&) override {
                for (uint32_t i = first; i < first + count; ++i)
                    if (const auto at = set.test(ray, i)) add(i, *at);
                return false;
            }
            const TriangleSet& set;
            const Ray& ray;
            const Add& add;
        } visitor(*set_, ray, add);
        TraversalLimits limits;
        if (structure_ != Structure::bvh) {
            visitor.on_leaf(0, static_cast<uint32_t>(flat_.ids.size()), limits);
        } else if (!bvh_.root.is_nothing()) {
            const MethodQuery query(*set_, ray);
            limits = query.initial_limits();
            traverse(bvh_, TraversalRay(query.traversal_ray(), bvh_), limits, visitor);
        }
    }

    void test_meshes(const Ray& ray, MethodQuery& query, TraversalLimits& limits) const {
        for (const MeshBounds& mesh : flat_.meshes) {
            const BoxQuery<double> box = {
                Vec3d(ray.origin),   Vec3d(ray.direction),           Vec3d(mesh.box.min),
                Vec3d(mesh.box.max), static_cast<double>(ray.tnear), query.ray_t_max(limits)};
            if (box_conservatively(box)) query.on_leaf(mesh.first, mesh.count, limits);
        }
    }

    void test_shape(const SurfaceId& id, Ray& rest, Hit& hit) const {
        const Instance& instance = scene_.instances[id.instance];
        Vec3d origin(rest.origin), direction(rest.direction);
        if (!instance.baked) {
            const Mat4d inverse(instance.world_to_object);
            inverse.multVecMatrix(Vec3d(rest.origin), origin);
            inverse.multDirMatrix(Vec3d(rest.direction), direction);
        }
        const auto tnear = static_cast<double>(rest.tnear), tfar = static_cast<double>(rest.tfar);
        const ShapeRoots roots =
            intersect_shape(scene_.shape(id.geometry), origin, direction, tnear, tfar);
        for (int i = 0; i < roots.count; ++i) {
            if (roots.t[i] <= tnear || static_cast<float>(roots.t[i]) >= hit.t) continue;
            hit = {static_cast<float>(roots.t[i]), 0, 0, 0, id.geometry, id.instance};
            rest.tfar = hit.t;
            return;
        }
    }

    const Scene& scene_;
    Structure structure_;
    FlatScene flat_;
    Bvh bvh_;
    std::unique_ptr<TriangleSet> set_;
};

class MethodIntersector : public Intersector {
  public:
    MethodIntersector(const Scene& scene, const TriangleMethod& method, Structure structure)
        : name_(method.name + suffix(structure)),
          opaque_(scene, false, method, structure),
          translucent_(scene, true, method, structure) {}

    void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence,
                 Visible visible) const override {
        for (size_t i = 0; i < rays.size(); ++i) hits[i] = find_closest(rays[i], visible);
    }

    void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked, Coherence,
                  Visible visible) const override {
        for (size_t i = 0; i < rays.size(); ++i) blocked[i] = bool(find_closest(rays[i], visible));
    }

    void all(std::span<const Ray> rays, std::vector<RayHit>& hits, Visible visible) const override {
        for (uint32_t i = 0; i < rays.size(); ++i) {
            if (!is_valid(rays[i])) continue;
            if (visible != Visible::translucent) opaque_.find_all(rays[i], i, hits);
            if (visible != Visible::opaque) translucent_.find_all(rays[i], i, hits);
        }
    }

    std::string description() const override { return "Sightline's reference, " + name_; }
    size_t memory() const override { return opaque_.memory() + translucent_.memory(); }

  private:
    static const char* suffix(Structure structure) {
        if (structure == Structure::bvh) return "";
        return structure == Structure::loop ? ":loop" : ":bounds";
    }

    Hit find_closest(const Ray& ray, Visible visible) const {
        Hit hit;
        if (!is_valid(ray)) return hit;
        if (visible != Visible::translucent) opaque_.find_closest(ray, hit);
        if (visible != Visible::opaque) translucent_.find_closest(ray, hit);
        return hit;
    }

    std::string name_;
    MethodScene opaque_, translucent_;
};

}  // namespace

std::unique_ptr<Intersector> make_method_intersector(const Scene& scene,
                                                     const TriangleMethod& method,
                                                     Structure structure) {
    check_arithmetic();
    return std::make_unique<MethodIntersector>(scene, method, structure);
}

}  // namespace sightline
