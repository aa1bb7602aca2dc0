#pragma once
// From the ids of a two-level BVH to those of a Hit.
#include "core/ray.h"
#include "scene/scene.h"

namespace sightline {

/// Maps the ids that a two-level BVH reports to those of a Hit, and counts what was dropped. The
/// top level holds the geometries of baked instances and, for each other instance, a reference to
/// its group.
class HitIdMap {
  public:
    /// Appends a geometry, as numbered in a Hit, to the current group.
    void add_geometry(uint32_t geometry) { geometries_.push_back(geometry); }

    /// The position of the next geometry.
    uint32_t next() const { return static_cast<uint32_t>(geometries_.size()); }

    /// Appends an entry of the top level: the geometries of `instance` begin at position `first`.
    void add_entry(uint32_t instance, uint32_t first) { entries_.push_back({instance, first}); }

    /// The Hit for geometry `geometry` below top-level entry `reference`; if that is `none`, for
    /// entry `geometry` of the top level itself.
    Hit resolve(float t, float u, float v, uint32_t primitive, uint32_t geometry,
                uint32_t reference) const {
        const bool nested = reference != none;
        const Entry& entry = entries_[nested ? reference : geometry];
        return {
            t, u, v, primitive, geometries_[entry.first + (nested ? geometry : 0)], entry.instance};
    }

    /// Counts the triangles that the engine drops: a coordinate is NaN or larger than `limit`.
    void count_dropped_triangles(std::span<const std::array<uint32_t, 3>> triangles,
                                 std::span<const Vec3> positions, float limit);

    /// Counts analytic shapes that were dropped because their instance's matrix has no usable
    /// inverse.
    void count_dropped_shapes(size_t count) { dropped_shapes_ += count; }

    /// What was dropped, one line each.
    std::vector<std::string> warnings() const;

  private:
    struct Entry {
        uint32_t instance, first;
    };
    std::vector<Entry> entries_;        // of the top level
    std::vector<uint32_t> geometries_;  // into Scene::meshes, then Scene::shapes
    size_t dropped_triangles_ = 0, dropped_shapes_ = 0;
};

}  // namespace sightline
