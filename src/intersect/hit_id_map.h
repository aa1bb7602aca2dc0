#pragma once
// What an engine of two levels is given of a scene, and what its answers stand for.
#include "core/ray.h"
#include "scene/scene.h"

namespace sightline {

/// Maps the numbers by which a two-level engine names what it hit to a Hit's. The top level holds
/// the geometries of baked instances and, for each other instance, a reference to its group.
class Placements {
  public:
    /// Appends a geometry, as a Hit numbers it, to the group being listed.
    void add_geometry(uint32_t geometry) { geometries_.push_back(geometry); }

    /// Where the next geometry will stand.
    uint32_t next() const { return static_cast<uint32_t>(geometries_.size()); }

    /// Appends an entry of the top level: the geometries of `instance` begin at `first`.
    void add_entry(uint32_t instance, uint32_t first) { entries_.push_back({instance, first}); }

    /// The Hit's indices of what the engine calls geometry `geometry` of top-level entry
    /// `reference`; of the top level itself where that is `none`.
    Hit resolve(float t, float u, float v, uint32_t primitive, uint32_t geometry,
                uint32_t reference) const {
        const bool nested = reference != none;
        const Entry& entry = entries_[nested ? reference : geometry];
        return {
            t, u, v, primitive, geometries_[entry.first + (nested ? geometry : 0)], entry.instance};
    }

    /// Counts the triangles that have a coordinate that is NaN or larger than `limit`: the engine
    /// leaves them out.
    void leave_out_triangles(const Mesh& mesh, float limit);

    /// Counts an instance that was left out because its matrix has no usable inverse.
    void leave_out_instance() { ++instances_left_out_; }

    /// What was left out, one line each.
    std::vector<std::string> warnings() const;

  private:
    struct Entry {
        uint32_t instance, first;
    };
    std::vector<Entry> entries_;        // by the top level's numbers
    std::vector<uint32_t> geometries_;  // into Scene::meshes, then Scene::shapes
    size_t triangles_left_out_ = 0, instances_left_out_ = 0;
};

/// How far out along an axis rays may start so that, seen from the instance, their coordinates stay
/// within `limit`; 0 where the matrix has no inverse that is of use in single precision.
float reach_of(const Mat4& object_to_world, float limit);

}  // namespace sightline
