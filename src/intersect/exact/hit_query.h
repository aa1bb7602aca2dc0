#pragma once
// Closest-hit and any-hit queries of one ray, with exact decisions on the candidates of the
// traversal.
#include "exact/bounded.h"
#include "intersect/exact/two_level_bvh.h"
#include "intersect/intersector.h"

#include <optional>

namespace sightline {

/// The power of two that brings the largest component of a direction into [1, 2), so that the
/// traversal's reciprocals cannot overflow. t along the scaled direction is t / scale.
inline double direction_scale(const Vec3& d) {
    const double largest = exact_double(max_abs_component(d));
    const uint64_t exponent = std::bit_cast<uint64_t>(largest) >> 52;
    return std::bit_cast<double>((2 * 1023 - exponent) << 52);
}

inline double reciprocal_of_power(double power_of_two) {
    return std::bit_cast<double>((uint64_t{2046} << 52) - std::bit_cast<uint64_t>(power_of_two));
}

/// The nearest floats not above and not below a number.
struct FloatInterval {
    float low, high;

    explicit FloatInterval(double x) : low(static_cast<float>(x)), high(low) {
        if (exact_double(low) == x) [[likely]]
            return;
        low = float_below(x);
        high = float_above(x);
    }
};

/// A query of one ray. Use: `initial_limits`, then `begin`, a traversal of the baked triangles with
/// this as the visitor unless begin returned true, then `finish`. t is in the units of the
/// traversal (a power of two times the ray's own) unless stated otherwise.
class HitQuery : public TriangleVisitor, public LeafVisitor {
  public:
    HitQuery(const TwoLevelBvh& bvh, const Ray& ray, Visible visible)
        : bvh_(bvh),
          ray_(ray),
          visible_(visible),
          scale_(direction_scale(ray.direction)),
          inverse_scale_(reciprocal_of_power(scale_)),
          direction_(Vec3d(ray.direction) * scale_),
          current_(&bvh.baked) {
        const FloatInterval near(to_traversal(exact_double(ray.tnear)));
        const FloatInterval far(to_traversal(exact_double(ray.tfar)));
        tnear_ = near.low;
        certain_t_min_ = near.high;
        certain_t_max_ = far.low;
        t_max_ = far.high;
    }

    /// The limits to start with. With a filter by visibility, every candidate must be looked up.
    TraversalLimits initial_limits() const {
        TraversalLimits limits;
        limits.t_max = t_max_;
        if (visible_ == Visible::all) {
            limits.certain_t_min = certain_t_min_;
            limits.certain_t_max = certain_t_max_;
        }
        return limits;
    }

    /// Tests the triangles that are in no BVH, and all others where the BVHs cannot be used.
    /// Returns true if nothing is left to search.
    bool begin(TraversalLimits& limits);

    /// The ray for the BVHs in world space.
    LocalRay world_ray() const { return {ray_.origin, direction_, tnear_}; }

    /// Takes over the hits of the baked triangles' traversal and, unless that was stopped, searches
    /// the upper level.
    void finish(TraversalLimits& limits, bool stopped);

    bool on_triangle(const TriangleCandidate& candidate, TraversalLimits& limits) final;
    bool on_leaf(uint32_t first, uint32_t count, TraversalLimits& limits) final;

  protected:
    /// Takes over the triangle that the kernel has accepted in the current BVH, if any.
    virtual void commit_pending(TraversalLimits& limits) = 0;

    /// Decides about a triangle. `certain`: the ray hits it within its segment. Returns true to
    /// stop.
    virtual bool test_triangle(const SurfaceId& id, const TriangleCandidate& candidate,
                               bool certain, TraversalLimits& limits) = 0;

    /// Takes a shape's first crossing within the segment and before t_max. Returns true to stop.
    virtual bool accept_shape(const SurfaceId& id, double ray_t, TraversalLimits& limits) = 0;

    static Hit hit_at(const SurfaceId& id, const PlaneHit& at) {
        return {static_cast<float>(at.t),
                static_cast<float>(at.u),
                static_cast<float>(at.v),
                id.primitive,
                id.geometry,
                id.instance};
    }

    bool is_hidden(uint32_t geometry) const {
        return visible_ != Visible::all &&
               (bvh_.translucent[geometry] != 0) != (visible_ == Visible::translucent);
    }

    /// The triangle of that number in the current BVH.
    SurfaceId surface(uint32_t triangle) const {
        SurfaceId id = current_->surface(triangle);
        if (id.instance == none) id.instance = instance_;
        return id;
    }

    /// From the ray's t to the traversal's and back: exact, unless it overflows.
    double to_traversal(double ray_t) const { return ray_t * inverse_scale_; }
    double to_ray(double t) const { return t * scale_; }

    const TwoLevelBvh& bvh_;
    const Ray& ray_;

  private:
    bool search_instance(const BvhObject& object, TraversalLimits& limits);
    /// Tests each triangle of a BVH, for rays that it cannot be searched for. True: stop.
    bool test_each(const MeshBvh& bvh, uint32_t instance, TraversalLimits& limits);
    void search_everything(TraversalLimits& limits);
    /// A shape or a single triangle. True: stop.
    bool test_object(const BvhObject& object, TraversalLimits& limits);
    bool test_shape(const BvhObject& object, TraversalLimits& limits);

    Visible visible_;
    double scale_, inverse_scale_;
    Vec3 direction_;  // scaled: its largest component lies in [1, 2)
    float tnear_, t_max_;
    float certain_t_min_, certain_t_max_;  // between them, t surely lies within the segment
    const MeshBvh* current_;
    uint32_t instance_ = none;  // of the current BVH
};

/// Finds the closest hit; of those at the same t the least (instance, geometry, primitive).
class ClosestHitQuery final : public HitQuery {
  public:
    using HitQuery::HitQuery;

    /// The result, after `finish`.
    Hit hit() const {
        if (best_.geometry == none) return {};
        return hit_at(best_,
                      shape_t_ ? PlaneHit{*shape_t_, 0, 0} : plane_hit(ray_, bvh_.triangle(best_)));
    }

    /// Prefetch what `hit` reads: first the triangle's indices, then the vertices they name.
    void prefetch_triangle() const;
    void prefetch_vertices() const;

  private:
    void commit_pending(TraversalLimits& limits) override;
    bool test_triangle(const SurfaceId& id, const TriangleCandidate& candidate, bool certain,
                       TraversalLimits& limits) override;
    bool accept_shape(const SurfaceId& id, double ray_t, TraversalLimits& limits) override;
    bool is_behind_best(const SurfaceId& id, const InstancedTriangle& triangle) const;
    void accept(const SurfaceId& id, float t_low, float t_high, TraversalLimits& limits);

    SurfaceId best_;
    float best_t_low_ = std::numeric_limits<float>::infinity();
    std::optional<double> shape_t_;  // the ray's t, if the best hit is a shape
};

/// Finds all hits, of a shape the first; some may be reported twice.
class AllHitsQuery final : public HitQuery {
  public:
    using HitQuery::HitQuery;

    /// The kernel accepts nothing by itself.
    TraversalLimits initial_limits() const {
        TraversalLimits limits;
        limits.t_max = HitQuery::initial_limits().t_max;
        return limits;
    }

    /// The result, after `finish`.
    std::span<const Hit> hits() const { return hits_; }

  private:
    void commit_pending(TraversalLimits&) override {}
    bool test_triangle(const SurfaceId& id, const TriangleCandidate& candidate, bool certain,
                       TraversalLimits& limits) override;
    bool accept_shape(const SurfaceId& id, double ray_t, TraversalLimits& limits) override;

    std::vector<Hit> hits_;
};

/// Finds whether there is any hit.
class AnyHitQuery final : public HitQuery {
  public:
    using HitQuery::HitQuery;

    TraversalLimits initial_limits() const {
        TraversalLimits limits = HitQuery::initial_limits();
        limits.stop_at_certain = true;
        return limits;
    }

    /// The result, after `finish`.
    bool occluded() const { return occluded_; }

  private:
    void commit_pending(TraversalLimits& limits) override {
        occluded_ |= limits.pending_triangle != none;
    }
    bool test_triangle(const SurfaceId& id, const TriangleCandidate& candidate, bool certain,
                       TraversalLimits& limits) override;
    bool accept_shape(const SurfaceId&, double, TraversalLimits&) override {
        return occluded_ = true;
    }

    bool occluded_ = false;
};

}  // namespace sightline
