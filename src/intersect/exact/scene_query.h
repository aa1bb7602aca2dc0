#pragma once
// Who decides, for one ray through a placed scene, what the traversal left open.
#include "exact/bounded.h"
#include "intersect/exact/two_level_bvh.h"
#include "intersect/intersector.h"

#include <optional>

namespace sightline {

/// The power of two that brings the largest component of a direction into [1, 2): trees take no
/// directions whose reciprocals overflow. t along the scaled direction is t / scale.
inline double scale_of(const Vec3& d) {
    const double fastest = exact_double(std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}));
    const uint64_t exponent = std::bit_cast<uint64_t>(fastest) >> 52;
    return std::bit_cast<double>((2 * 1023 - exponent) << 52);
}

inline double reciprocal_of_power(double power_of_two) {
    return std::bit_cast<double>((uint64_t{2046} << 52) - std::bit_cast<uint64_t>(power_of_two));
}

/// The floats around a number, mostly one.
struct Floats {
    float below, above;

    explicit Floats(double x) : below(static_cast<float>(x)), above(below) {
        if (exact_double(below) == x) [[likely]]
            return;
        below = float_below(x);
        above = float_above(x);
    }
};

/// A ray on its way through a placed scene: common to the nearest hit and to any hit.
class SceneJudge : public Judge {
  public:
    SceneJudge(const PlacedScene& placed, const Ray& ray, Visible visible)
        : placed_(placed),
          ray_(ray),
          visible_(visible),
          scale_(scale_of(ray.direction)),
          per_scale_(reciprocal_of_power(scale_)),
          direction_(Vec3d(ray.direction) * scale_),
          tree_(&placed.baked) {
        const Floats near(to_tree(exact_double(ray.tnear))), far(to_tree(exact_double(ray.tfar)));
        tnear_ = near.below;
        surely_past_near_ = near.above;
        surely_before_far_ = far.below;
        reach = far.above;
        if (visible != Visible::all) return;  // every finding must be asked what it is
        sure_from = surely_past_near_;
        sure_to = surely_before_far_;
    }

    /// Looks at what no tree holds. True where nothing is left to search.
    bool begin();

    /// The ray as the world's trees take it, after `begin`.
    LocalRay world_ray() const { return {ray_.origin, direction_, tnear_}; }

    /// Takes the ray through the tree of objects, after that of the baked triangles.
    void search_objects();

    bool offer(const Finding& finding) override;
    bool visit(uint32_t first, uint32_t count) override;

  protected:
    /// Takes over what the traversal has found by itself in the present tree.
    virtual void settle() = 0;

    /// A triangle that the ray surely hits within its segment (and nearer than the best), or that
    /// must be decided exactly. True: stop.
    virtual bool take(const SurfaceId& id, const Finding& finding, bool sure) = 0;

    /// A shape's crossings, ascending, within the segment and before `reach`. True: stop.
    virtual bool take_shape(const SurfaceId& id, double t) = 0;

    bool is_hidden(uint32_t geometry) const {
        return visible_ != Visible::all &&
               (placed_.translucent[geometry] != 0) != (visible_ == Visible::translucent);
    }

    /// A triangle of the present tree.
    SurfaceId surface(uint32_t triangle) const {
        SurfaceId id = tree_->surface(triangle);
        if (id.instance == none) id.instance = instance_;
        return id;
    }

    /// From the ray's t to the traversal's and back: a power of two.
    double to_tree(double t) const { return t * per_scale_; }
    double to_world(double t) const { return t * scale_; }

    const PlacedScene& placed_;
    const Ray& ray_;
    float surely_past_near_, surely_before_far_;  ///< in the traversal's measure

  private:
    bool enter_meshes(const PlacedObject& object);
    bool meet_shape(const PlacedObject& object);

    Visible visible_;
    double scale_, per_scale_;
    Vec3 direction_;  ///< scaled: its largest component lies in [1, 2)
    float tnear_;
    const MeshTree* tree_;
    uint32_t instance_ = none;
};

/// Finds the nearest hit; of those at the same t the least (instance, geometry, primitive).
class NearestJudge final : public SceneJudge {
  public:
    using SceneJudge::SceneJudge;

    void settle() override {
        if (found == none) return;
        best_ = surface(found);
        found = none;
        low_ = sure_to;
        shape_t_.reset();
    }

    /// What was found, once `settle` has been called.
    Hit hit() const {
        if (best_.geometry == none) return {};
        const PlaneHit at =
            shape_t_ ? PlaneHit{*shape_t_, 0, 0} : plane_hit(ray_, placed_.triangle(best_));
        return {static_cast<float>(at.t), static_cast<float>(at.u), static_cast<float>(at.v),
                best_.primitive,          best_.geometry,           best_.instance};
    }

    /// Ask memory for what `hit` will read: the second for what the first has brought.
    void prefetch_triangle() const;
    void prefetch_corners() const;

  private:
    bool take(const SurfaceId& id, const Finding& finding, bool sure) override;
    bool take_shape(const SurfaceId& id, double t) override;
    bool is_farther(const SurfaceId& id, const PlacedTriangle& triangle) const;
    void accept(const SurfaceId& id, float low, float high);

    SurfaceId best_;
    float low_ = std::numeric_limits<float>::infinity();  ///< of the best hit's t
    std::optional<double> shape_t_;                       ///< where the best hit is a shape
};

/// Finds whether there is any hit.
class AnyJudge final : public SceneJudge {
  public:
    AnyJudge(const PlacedScene& placed, const Ray& ray, Visible visible)
        : SceneJudge(placed, ray, visible) {
        stops_at_sure = true;
    }

    void settle() override {}
    bool blocked() const { return blocked_ || found != none; }
    void prefetch_triangle() const {}
    void prefetch_corners() const {}

  private:
    bool take(const SurfaceId& id, const Finding& finding, bool sure) override;
    bool take_shape(const SurfaceId&, double) override { return blocked_ = true; }

    bool blocked_ = false;
};

}  // namespace sightline
