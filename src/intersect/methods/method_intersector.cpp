#include "intersect/methods/method_intersector.h"

#include "core/error.h"
#include "exact/bounded.h"
#include "exact/referee.h"
#include "intersect/exact/scene_query.h"
#include "intersect/methods/boxes.h"
#include "intersect/methods/triangle_methods.h"
#include "intersect/ray_rules.h"
#include "intersect/shapes.h"

#include <algorithm>

namespace sightline {
namespace {

enum class Structure { tree, bounds, loop };

/// A run of triangles with a box around it: a leaf of the tree, or a mesh.
struct Run {
    Box3 box;
    uint32_t first, count;
};

/// All triangles in world coordinates, rounded to floats, and by what they are found.
struct FlatScene {
    std::vector<Corners<float>> triangles;
    std::vector<SurfaceId> ids;
    std::vector<Box3> boxes;
    std::vector<Run> meshes;
    std::vector<SurfaceId> shapes;

    /// Those whose material is translucent, or those whose is not.
    FlatScene(const Scene& scene, bool translucent) {
        const auto wanted = [&](uint32_t geometry) {
            const uint32_t material = scene.material_of(geometry);
            const bool lets_through =
                material < scene.materials.size() && is_translucent(scene.materials[material]);
            return lets_through == translucent;
        };
        const auto first_shape = static_cast<uint32_t>(scene.meshes.size());
        for (uint32_t i = 0; i < scene.instances.size(); ++i) {
            const Group& group = scene.groups[scene.instances[i].group];
            for (const uint32_t mesh : group.meshes)
                if (wanted(mesh)) add(scene, i, mesh);
            for (const uint32_t shape : group.shapes)
                if (wanted(first_shape + shape)) shapes.push_back({i, first_shape + shape, 0});
        }
    }

    /// Puts triangle order[i] at place i.
    void sort(const std::vector<uint32_t>& order) {
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
        const auto place = [&](uint32_t corner) {
            const Vec3& p = mesh.positions[corner];
            return instance.baked ? p : transform_point(p, instance.object_to_world);
        };
        Run run{{}, static_cast<uint32_t>(ids.size()), 0};
        for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
            const auto& [a, b, c] = mesh.triangles[i];
            const Corners<float> triangle = {place(a), place(b), place(c)};
            Box3 box(triangle.a);
            box.extendBy(triangle.b);
            box.extendBy(triangle.c);
            const Vec3 s = triangle.a + triangle.b + triangle.c;
            if (!(std::abs(s.x) + std::abs(s.y) + std::abs(s.z) < 0x1p85f)) continue;
            triangles.push_back(triangle);
            ids.push_back({index, geometry, i});
            boxes.push_back(box);
            run.box.extendBy(box);
            ++run.count;
        }
        if (run.count > 0) meshes.push_back(run);
    }
};

/// What one ray has met.
class MethodJudge : public Judge {
  public:
    MethodJudge(const TriangleSet& set, const Ray& ray)
        : best{static_cast<double>(ray.tfar)},
          set_(set),
          ray_(ray),
          scale_(scale_of(ray.direction)) {
        reach = float_above(exact_double(ray.tfar) / scale_);
    }

    /// The ray as trees take it.
    LocalRay tree_ray() const {
        return {ray_.origin, Vec3(Vec3d(ray_.direction) * scale_),
                float_below(exact_double(ray_.tnear) / scale_)};
    }
    /// How far there is to go, in the ray's own measure.
    double ray_reach() const { return static_cast<double>(reach) * scale_; }

    bool offer(const Finding&) override { return false; }
    bool visit(uint32_t first, uint32_t count) override {
        set_.nearest(ray_, first, count, best);
        // A little beyond, since the method's t and the box's are rounded differently.
        reach = std::min(reach, float_above(best.t / scale_ * (1 + 0x1p-20)));
        return false;
    }

    NearestTriangle best;

  private:
    const TriangleSet& set_;
    const Ray& ray_;
    double scale_;
};

/// One method over the opaque or the translucent part of a scene.
class MethodTree {
  public:
    MethodTree(const Scene& scene, bool translucent, const TriangleMethod& method,
               Structure structure)
        : scene_(scene), structure_(structure), flat_(scene, translucent) {
        if (structure == Structure::tree) {
            tree_ = build_tree(flat_.boxes, 1);
            flat_.sort(tree_.order);
        }
        set_ = method.prepare(flat_.triangles);
        flat_.triangles = {};
        flat_.boxes = {};
    }

    /// Replaces `hit` where something is nearer.
    void nearest(const Ray& ray, Hit& hit) const {
        Ray rest = ray;
        rest.tfar = std::min(ray.tfar, hit.t);
        MethodJudge judge(*set_, rest);
        if (structure_ == Structure::loop)
            judge.visit(0, static_cast<uint32_t>(flat_.ids.size()));
        else if (structure_ == Structure::bounds)
            visit_meshes(rest, judge);
        else if (!tree_.root.is_nothing())
            traverse(tree_, TreeRay(judge.tree_ray(), tree_), judge);
        const NearestTriangle& best = judge.best;
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
        for (const SurfaceId& id : flat_.shapes) meet_shape(id, rest, hit);
    }

    size_t memory() const { return set_->memory() + tree_.nodes.size() * sizeof(WideNode); }

  private:
    void visit_meshes(const Ray& ray, MethodJudge& judge) const {
        for (const Run& run : flat_.meshes) {
            const BoxQuery<double> query = {
                Vec3d(ray.origin),  Vec3d(ray.direction),           Vec3d(run.box.min),
                Vec3d(run.box.max), static_cast<double>(ray.tnear), judge.ray_reach()};
            if (box_conservatively(query)) judge.visit(run.first, run.count);
        }
    }

    void meet_shape(const SurfaceId& id, Ray& rest, Hit& hit) const {
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
    BoxTree tree_;
    std::unique_ptr<TriangleSet> set_;
};

class MethodIntersector : public Intersector {
  public:
    MethodIntersector(const Scene& scene, const TriangleMethod& method, Structure structure,
                      std::string_view name)
        : name_(name),
          opaque_(scene, false, method, structure),
          translucent_(scene, true, method, structure) {}

    void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence,
                 Visible visible) const override {
        for (size_t i = 0; i < rays.size(); ++i) hits[i] = nearest(rays[i], visible);
    }

    void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked, Coherence,
                  Visible visible) const override {
        for (size_t i = 0; i < rays.size(); ++i) blocked[i] = bool(nearest(rays[i], visible));
    }

    std::string description() const override { return "Sightline's reference, " + name_; }
    size_t memory() const override { return opaque_.memory() + translucent_.memory(); }

  private:
    Hit nearest(const Ray& ray, Visible visible) const {
        Hit hit;
        if (!is_valid(ray)) return hit;
        if (visible != Visible::translucent) opaque_.nearest(ray, hit);
        if (visible != Visible::opaque) translucent_.nearest(ray, hit);
        return hit;
    }

    std::string name_;
    MethodTree opaque_, translucent_;
};

}  // namespace

std::unique_ptr<Intersector> make_method_tree(const Scene& scene, std::string_view name) {
    const size_t colon = name.find(':');
    const TriangleMethod& method = triangle_method(name.substr(0, colon));
    const std::string_view rest = colon == name.npos ? "" : name.substr(colon + 1);
    if (rest != "" && rest != "bounds" && rest != "loop")
        throw Error("unknown structure '" + std::string(rest) + "' of method '" +
                    std::string(name) + "'; there are bounds and loop");
    const Structure structure = rest == "loop"     ? Structure::loop
                                : rest == "bounds" ? Structure::bounds
                                                   : Structure::tree;
    return std::make_unique<MethodIntersector>(scene, method, structure, name);
}

}  // namespace sightline
