#pragma once
// Surfaces that nothing else in the scene comes near: hits on them coincide with no other hit.
#include "intersect/intersector.h"

#include <atomic>
#include <cstdint>

namespace sightline {

/// Remembers for triangles and shapes whether anything else may lie at the place of a hit on them.
/// Each is judged once it has been asked about some times, by what the engine finds nearby. The
/// judgement depends on scene and engine alone, and a lone surface's hits need no search, so that
/// pictures do not depend on the order in which threads ask. Refers to what it is given.
class LoneSurfaces {
  public:
    LoneSurfaces(const Scene& scene, const Intersector& intersector);

    /// True only if no other surface within `distance` of the hit comes so near to the plane of its
    /// triangle that their error bounds overlap. Often false where that is so, too: before a
    /// surface is judged, along its edges, and where much is nearby.
    bool is_lone(const Hit& hit, float distance) const;

  private:
    float judge_triangle(const Hit& hit) const;
    float judge_shape(const Hit& hit) const;

    const Scene& scene_;
    const Intersector& intersector_;
    std::vector<uint64_t> first_ids_;  // by instance: running numbers of all surfaces
    std::vector<uint32_t> offsets_;    // by geometry, within its group
    size_t mask_ = 0;                  // of an id: its place in records_
    mutable std::vector<std::atomic<uint64_t>> records_;
};

}  // namespace sightline
