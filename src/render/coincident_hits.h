#pragma once
// Coincident surfaces: those at distances along a ray that their error bounds cannot tell apart.
#include "intersect/intersector.h"
#include "shade/surface.h"

namespace sightline {

/// Boxes in world space around all surfaces that transmit.
std::vector<Box3> translucent_bounds(const Scene& scene);

/// Finds all surfaces that coincide with a hit. One for each thread; refers to what it is given.
class CoincidentHits {
  public:
    /// `bounds`: those of translucent_bounds.
    CoincidentHits(const Scene& scene, const Intersector& intersector, std::span<const Box3> bounds)
        : scene_(scene), intersector_(intersector), translucent_bounds_(bounds) {}

    /// True if surfaces that a ray goes on behind may coincide with this one, although the ray
    /// does not go on behind it.
    bool may_be_covered(const Surface& surface) const;

    /// The closest hit of a ray and those that coincide with it, in the order in which the ray
    /// visits them, the same for every engine: front faces before back faces, so that the next
    /// solid is entered before the last is left and both form one interface; then transmitting
    /// surfaces before opaque ones; then by ids. `surface` is the closest hit's. Valid until the
    /// next call.
    std::span<const Hit> find(const Ray& ray, const Hit& closest, const Surface& surface,
                              Visible visible);

    /// Widens the error bound of a surface among those found last, so that rays that leave it start
    /// outside the bounds of all.
    void widen(Surface& surface) const;

  private:
    struct Member {
        Hit hit;
        float depth, error;  // along the first normal: behind the closest hit, and its bound
        bool front, opaque;
        Vec3 position, position_error;
    };
    Member member(const Ray& ray, const Hit& hit) const;
    void list_members(const Ray& ray, const Hit& closest);
    void keep_connected();
    void order_hits();
    bool repeats_neighbour(const Member& a, const Member& b) const;

    const Scene& scene_;
    const Intersector& intersector_;
    std::span<const Box3> translucent_bounds_;
    std::vector<RayHit> found_;
    std::vector<Member> members_;
    std::vector<Hit> hits_;
    Vec3 normal_;  // of the closest hit, on the ray's side
};

}  // namespace sightline
