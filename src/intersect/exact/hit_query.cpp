#include "intersect/exact/hit_query.h"

#include "intersect/shapes.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// From origins beyond this the traversal's products overflow: every triangle is tested.
constexpr float max_origin = 0x1p90f;

/// A candidate without bounds of t.
TriangleCandidate unknown(uint32_t primitive) { return {primitive, false, -infinity, infinity}; }

}  // namespace

bool HitQuery::begin(TraversalLimits& limits) {
    for (const SurfaceId& id : bvh_.unbounded)
        if (!is_hidden(id.geometry) && test_triangle(id, unknown(id.primitive), false, limits))
            return true;
    if (max_abs_component(ray_.origin) <= max_origin) return false;
    search_everything(limits);
    return true;
}

bool HitQuery::test_each(const MeshBvh& bvh, uint32_t instance, TraversalLimits& limits) {
    for (const MeshRange& range : bvh.meshes) {
        if (is_hidden(range.geometry)) continue;
        const auto count =
            static_cast<uint32_t>(bvh_.scene.meshes[range.geometry].triangles.size());
        for (uint32_t i = 0; i < count; ++i) {
            const SurfaceId id{range.instance == none ? instance : range.instance, range.geometry,
                               i};
            if (is_finite(bvh_.triangle(id)) && test_triangle(id, unknown(i), false, limits))
                return true;
        }
    }
    return false;
}

void HitQuery::search_everything(TraversalLimits& limits) {
    if (test_each(bvh_.baked, none, limits)) return;
    for (const BvhObject& object : bvh_.objects) {
        const bool meshes = object.kind == BvhObject::Kind::meshes;
        if (meshes ? test_each(bvh_.groups[object.index], object.instance, limits)
                   : test_object(object, limits))
            return;
    }
}

void HitQuery::finish(TraversalLimits& limits, bool stopped) {
    commit_pending(limits);
    const Bvh& bvh = bvh_.object_bvh;
    if (!stopped && !bvh.root.is_nothing())
        traverse(bvh, TraversalRay(world_ray(), bvh), limits, *this);
}

bool HitQuery::on_triangle(const TriangleCandidate& candidate, TraversalLimits& limits) {
    commit_pending(limits);
    const SurfaceId id = surface(candidate.triangle);
    if (is_hidden(id.geometry)) return false;
    const bool certain =
        candidate.certain && candidate.t_low > certain_t_min_ && candidate.t_high < certain_t_max_;
    return test_triangle(id, candidate, certain, limits);
}

bool HitQuery::on_leaf(uint32_t first, uint32_t count, TraversalLimits& limits) {
    for (uint32_t i = first; i < first + count; ++i) {
        const BvhObject& object = bvh_.objects[i];
        if (object.kind == BvhObject::Kind::meshes ? search_instance(object, limits)
                                                   : test_object(object, limits))
            return true;
    }
    return false;
}

bool HitQuery::test_object(const BvhObject& object, TraversalLimits& limits) {
    if (is_hidden(object.index)) return false;
    if (object.kind == BvhObject::Kind::shape) return test_shape(object, limits);
    return test_triangle({object.instance, object.index, object.primitive},
                         unknown(object.primitive), false, limits);
}

bool HitQuery::search_instance(const BvhObject& object, TraversalLimits& limits) {
    current_ = &bvh_.groups[object.index];
    instance_ = object.instance;
    const LocalRay local =
        bvh_.world_to_object[object.instance].transform(ray_.origin, direction_, tnear_);
    if (!(max_abs_component(local.origin) <= max_origin))
        return test_each(*current_, instance_, limits);
    const TriangleBvh& triangles = current_->triangles;
    const TraversalRay ray(local, triangles.bvh, triangles.max_edge);
    // The box in object space is often smaller than the one in the world, and an inner node's
    // children are tested anyway.
    if (triangles.bvh.root.is_leaf() && !ray.may_enter(triangles.bvh.bounds, limits.t_max))
        return false;
    const bool stopped = traverse(triangles, ray, limits, *this);
    commit_pending(limits);
    return stopped;
}

bool HitQuery::test_shape(const BvhObject& object, TraversalLimits& limits) {
    Vec3d origin(ray_.origin), direction(ray_.direction);
    if (!bvh_.scene.instances[object.instance].baked) {
        const WorldToObject& inverse = bvh_.world_to_object[object.instance];
        origin = (origin - inverse.translation) * inverse.linear;
        direction = direction * inverse.linear;
    }
    const double tnear = exact_double(ray_.tnear);
    const double tfar =
        std::min(exact_double(ray_.tfar), to_ray(static_cast<double>(limits.t_max)));
    const ShapeRoots roots =
        intersect_shape(bvh_.scene.shape(object.index), origin, direction, tnear, tfar);
    for (int i = 0; i < roots.count; ++i)
        if (roots.t[i] > tnear)
            return accept_shape({object.instance, object.index, 0}, roots.t[i], limits);
    return false;
}

void ClosestHitQuery::commit_pending(TraversalLimits& limits) {
    if (limits.pending_triangle == none) return;
    best_ = surface(limits.pending_triangle);
    limits.pending_triangle = none;
    best_t_low_ = limits.certain_t_max;
    shape_t_.reset();
}

bool ClosestHitQuery::test_triangle(const SurfaceId& id, const TriangleCandidate& candidate,
                                    bool certain, TraversalLimits& limits) {
    if (certain && candidate.t_high < best_t_low_) {
        accept(id, candidate.t_low, candidate.t_high, limits);
        return false;
    }
    if (id == best_) return false;
    const InstancedTriangle triangle = bvh_.triangle(id);
    if (!certain && exact_crossing(ray_, triangle) != Crossing::hit) return false;
    if (is_behind_best(id, triangle)) return false;
    float t_low = candidate.t_low, t_high = candidate.t_high;
    if (!std::isfinite(t_low) || !std::isfinite(t_high)) {
        const Enclosure t = enclose_t(ray_, triangle);
        t_low = float_below(to_traversal(t.low));
        t_high = float_above(to_traversal(t.high));
    }
    accept(id, t_low, t_high, limits);
    return false;
}

bool ClosestHitQuery::is_behind_best(const SurfaceId& id, const InstancedTriangle& triangle) const {
    if (best_.geometry == none) return false;
    int order = 0;
    if (shape_t_) {
        const double t = exact_t(ray_, triangle);
        order = t < *shape_t_ ? -1 : t > *shape_t_;
    } else {
        order = compare_exactly(ray_, triangle, bvh_.triangle(best_));
    }
    return order != 0 ? order > 0 : best_ < id;
}

bool ClosestHitQuery::accept_shape(const SurfaceId& id, double ray_t, TraversalLimits& limits) {
    const double t = to_traversal(ray_t);
    if (!(t < static_cast<double>(best_t_low_))) {
        if (t > static_cast<double>(limits.t_max)) return false;
        const double best = shape_t_ ? *shape_t_ : exact_t(ray_, bvh_.triangle(best_));
        if (ray_t > best || (ray_t == best && best_ < id)) return false;
    }
    accept(id, float_below(t), float_above(t), limits);
    shape_t_ = ray_t;
    return false;
}

void ClosestHitQuery::accept(const SurfaceId& id, float t_low, float t_high,
                             TraversalLimits& limits) {
    best_ = id;
    best_t_low_ = t_low;
    limits.certain_t_max = std::min(limits.certain_t_max, t_low);
    limits.t_max = std::min(limits.t_max, t_high);
    shape_t_.reset();
}

void ClosestHitQuery::prefetch_triangle() const {
    if (best_.geometry == none || shape_t_) return;
    __builtin_prefetch(&bvh_.scene.meshes[best_.geometry].triangles[best_.primitive]);
}

void ClosestHitQuery::prefetch_vertices() const {
    if (best_.geometry == none || shape_t_) return;
    const Mesh& mesh = bvh_.scene.meshes[best_.geometry];
    for (const uint32_t vertex : mesh.triangles[best_.primitive])
        __builtin_prefetch(&mesh.positions[vertex]);
}

bool AllHitsQuery::test_triangle(const SurfaceId& id, const TriangleCandidate&, bool certain,
                                 TraversalLimits&) {
    const InstancedTriangle triangle = bvh_.triangle(id);
    if (certain || exact_crossing(ray_, triangle) == Crossing::hit)
        hits_.push_back(hit_at(id, plane_hit(ray_, triangle)));
    return false;
}

bool AllHitsQuery::accept_shape(const SurfaceId& id, double ray_t, TraversalLimits&) {
    hits_.push_back(hit_at(id, {ray_t, 0, 0}));
    return false;
}

bool AnyHitQuery::test_triangle(const SurfaceId& id, const TriangleCandidate&, bool certain,
                                TraversalLimits&) {
    return occluded_ = certain || exact_crossing(ray_, bvh_.triangle(id)) == Crossing::hit;
}

}  // namespace sightline
