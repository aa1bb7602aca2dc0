#pragma once
// The scene as the exact intersector holds it: one BVH over all baked triangles, one for each group
// that is instanced, and one over the instances.
#include "core/ray.h"
#include "exact/referee.h"
#include "exact/triangle.h"
#include "intersect/bvh/traversal_kernel.h"
#include "scene/scene.h"

#include <algorithm>

namespace sightline {

/// The triangles of one mesh within a BVH.
struct MeshRange {
    uint32_t geometry;
    uint32_t instance;  ///< none if the BVH is instanced
    uint32_t first;     ///< the number of its first triangle in the BVH
};

/// A BVH over the triangles of several meshes.
struct MeshBvh {
    TriangleBvh triangles;
    std::vector<MeshRange> meshes;

    /// The triangle of that number.
    SurfaceId surface(uint32_t triangle) const {
        const auto next = std::upper_bound(
            meshes.begin(), meshes.end(), triangle,
            [](uint32_t number, const MeshRange& mesh) { return number < mesh.first; });
        const MeshRange& mesh = next[-1];
        return {mesh.instance, mesh.geometry, triangle - mesh.first};
    }
};

/// The inverse of an instance's matrix in double precision, in two cache lines.
struct alignas(64) WorldToObject {
    Vec3d translation;  ///< subtracted first
    Imath::M33d linear;
    Vec3d row_sizes{0, 0, 0};  ///< of the largest element in each row of `linear`
    double residual = 0;       ///< bounds the elements of M·M⁻¹ − 1

    /// The ray in object space, rounded to floats, with bounds of all errors.
    LocalRay transform(const Vec3& origin, const Vec3& direction, float tnear) const;
};

/// A leaf of the upper level.
struct BvhObject {
    enum class Kind : uint8_t { meshes, shape, triangle };

    Kind kind;
    uint32_t instance;
    uint32_t index;          ///< meshes: into TwoLevelBvh::groups; shape, triangle: the geometry
    uint32_t primitive = 0;  ///< of a triangle
};

/// All BVHs of a scene. Plain data, built once.
class TwoLevelBvh {
  public:
    /// Triangles are split where that pays off, unless `may_split` is false. `scene` must outlive
    /// the result.
    explicit TwoLevelBvh(const Scene& scene, bool may_split = true);

    const Scene& scene;
    MeshBvh baked;
    std::vector<MeshBvh> groups;
    std::vector<BvhObject> objects;  ///< in the order of object_bvh's blocks
    Bvh object_bvh;
    std::vector<SurfaceId> unbounded;            ///< triangles too large for float boxes
    std::vector<WorldToObject> world_to_object;  ///< by instance; unused if it is baked
    std::vector<uint8_t> translucent;            ///< by geometry

    InstancedTriangle triangle(const SurfaceId& id) const { return instanced_triangle(scene, id); }

    /// Bytes.
    size_t memory() const;
};

}  // namespace sightline
