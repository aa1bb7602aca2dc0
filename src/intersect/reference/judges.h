#pragma once
// Who decides, for one ray through a placed scene, what the traversal left open.
#include "intersect/intersector.h"
#include "intersect/reference/placed_scene.h"

#include <optional>

namespace sightline {

/// The power of two that brings the largest component of a direction into [1, 2): trees take no
/// directions whose reciprocals overflow. t along the scaled direction is t / scale.
double scale_of(const Vec3& direction);

/// A ray on its way through a placed scene: common to the nearest hit and to any hit.
class SceneJudge : public Judge {
  public:
    SceneJudge(const PlacedScene& placed, const Ray& ray, Visible visible);

    /// Looks at what no tree holds. True where nothing is left to search.
    bool begin();

    /// The ray as the world's trees take it, after `begin`.
    LocalRay world_ray() const { return {ray_.origin, direction_, tnear_}; }

    /// Takes the ray through the tree of objects, after that of the baked triangles.
    void search_objects();

    bool offer(const Finding& finding) override;
    bool visit(uint32_t first, uint32_t count) override;

  protected:
    /// A triangle that the ray surely hits within its segment (and nearer than the best), or that
    /// must be decided exactly. True: stop.
    virtual bool take(const SurfaceId& id, const Finding& finding, bool sure) = 0;

    /// A shape's crossings, ascending, within the segment and before `reach`. True: stop.
    virtual bool take_shape(const SurfaceId& id, double t) = 0;

    bool is_hidden(uint32_t geometry) const {
        return visible_ != Visible::all &&
               (placed_.translucent[geometry] != 0) != (visible_ == Visible::translucent);
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
class NearestJudge : public SceneJudge {
  public:
    using SceneJudge::SceneJudge;

    Hit hit() const;

    /// Asks memory for what `hit` will read.
    void prefetch_hit() const;

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
class AnyJudge : public SceneJudge {
  public:
    using SceneJudge::SceneJudge;

    bool blocked() const { return blocked_; }
    void prefetch_hit() const {}

  private:
    bool take(const SurfaceId& id, const Finding& finding, bool sure) override;
    bool take_shape(const SurfaceId&, double) override { return blocked_ = true; }

    bool blocked_ = false;
};

}  // namespace sightline
