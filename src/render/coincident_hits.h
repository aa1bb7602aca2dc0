#pragma once
// Coincident surfaces: those at distances along a ray that their error bounds cannot tell apart.
#include "render/lone_surfaces.h"
#include "shade/surface.h"

#include <optional>

namespace sightline {

/// How many surfaces are evaluated before what coincides with them is searched for, in calls for
/// many rays: as many as stay in the cache.
inline constexpr size_t surface_block = 64;

/// Boxes in world space around all surfaces that transmit.
std::vector<Box3> translucent_bounds(const Scene& scene);

/// Finds all surfaces that coincide with hits, for many rays at once. One for each thread; refers
/// to what it is given.
class CoincidentHits {
  public:
    /// `bounds`: those of translucent_bounds.
    CoincidentHits(const Scene& scene, const Intersector& intersector, const LoneSurfaces& lone,
                   std::span<const Box3> bounds)
        : scene_(scene), intersector_(intersector), lone_(lone), translucent_bounds_(bounds) {}

    /// True if surfaces that a ray goes on behind may coincide with this one, although the ray
    /// does not go on behind it.
    bool may_be_covered(const Surface& surface) const;

    /// Drops what was added.
    void clear() { queries_.clear(), segments_.clear(), found_.clear(); }

    /// Adds a ray with its closest hit, whose surface is `surface`, and returns its index; nothing
    /// if it is known that nothing coincides with it.
    std::optional<size_t> add(const Ray& ray, const Hit& closest, const Surface& surface);

    /// Searches around all hits that were added.
    void search(Visible visible);

    /// After search(): the closest hit of the ray with this index and those that coincide with it,
    /// in the order in which the ray visits them, the same for every engine: front faces before
    /// back faces, so that the next solid is entered before the last is left and both form one
    /// interface; then transmitting surfaces before opaque ones; then by ids. Valid until the next
    /// call.
    std::span<const Hit> at(size_t index);

    /// Widens the error bound of a surface among those that at() returned last, so that rays that
    /// leave it start outside the bounds of all.
    void widen(Surface& surface) const;

  private:
    struct Query {
        Ray ray;
        Hit closest;
        Vec3 normal;  // of the closest hit, on the ray's side
    };
    struct Member {
        Hit hit;
        float depth, error;  // behind the closest hit, along its normal, and the bound
        bool front, opaque;
        Vec3 position, position_error;
    };
    Member member(const Ray& ray, const Hit& hit) const;
    void list_members(const Query& query, std::span<const RayHit> others);
    void keep_connected();
    void order_hits();
    bool repeats_neighbour(const Member& a, const Member& b) const;

    const Scene& scene_;
    const Intersector& intersector_;
    const LoneSurfaces& lone_;
    std::span<const Box3> translucent_bounds_;
    std::vector<Query> queries_;
    std::vector<Ray> segments_;  // by query: the ray around its closest hit
    std::vector<RayHit> found_;  // on them, by query, without the closest hits
    std::vector<Member> members_;
    std::vector<Hit> hits_;
};

}  // namespace sightline
