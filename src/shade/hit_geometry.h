#pragma once
// The geometry at a hit, before any material.
#include "core/ray.h"
#include "scene/scene.h"

namespace sightline {

/// Gradients of the texture coordinates u and v along a surface, in units of 1 / world length.
struct UvGradients {
    Vec3 u{0, 0, 0}, v{0, 0, 0};
};

/// World space. Directions are unit vectors unless said otherwise.
struct HitGeometry {
    const Mesh* mesh = nullptr;  ///< exactly one of these two is set
    const Shape* shape = nullptr;
    const Instance* instance = nullptr;
    std::array<uint32_t, 3> corners{0, 0, 0};  ///< vertices of the triangle
    float weights[3] = {1, 0, 0};              ///< barycentric
    Vec3 position;
    Vec3 position_error;
    Vec3 edge1, edge2;   ///< triangle's edges from its first corner (meshes only)
    Vec3 outward;        ///< geometric normal of the front side
    Vec3 normal;         ///< interpolated; on the side of the vertex normals
    Vec3 shape_tangent;  ///< shapes only
    float area2 = 0;     ///< twice the triangle's area
    bool has_vertex_normals = false;
    Vec2 uv{0, 0};  ///< TEXCOORD_0

    /// The triangle's texture coordinates of one set at the hit; shapes have one set only.
    Vec2 texcoord(uint32_t set) const;
    /// Zero if the mesh has no such set or the triangle no area.
    UvGradients uv_gradients(uint32_t set) const;
    /// Interpolated COLOR_0.
    Vec4 color() const;
    /// Unit tangent along growing u', orthogonal to `normal`, with a sign in `w` such that
    /// cross(normal, tangent)·w points up in the texture: the mesh's own, or from texture set
    /// `set`. u' is the coordinate after the texture's transform, uv' = u·across + v·down + offset;
    /// the mesh's own tangent belongs to the coordinates before it.
    Vec4 tangent(uint32_t set, Vec2 across = {1, 0}, Vec2 down = {0, 1}) const;
    /// From `position` to the mean of its projections onto the tangent planes of those corners
    /// whose plane lies above it on the side of `facing` (Hanika 2021, "Hacking the Shadow
    /// Terminator"); zero on concave and flat triangles.
    Vec3 shadow_terminator_offset(const Vec3& facing) const;

  private:
    Vec4 own_tangent() const;  // zero if there is none
    Vec4 tangent_from_uv(uint32_t set, Vec2 across, Vec2 down) const;
};

/// The geometry at a hit. `ray` locates hits on shapes and may be null for meshes. Without
/// `needs_uv` the texture coordinates and tangents are not set.
HitGeometry hit_geometry(const Scene& scene, const Hit& hit, const Ray* ray, bool needs_uv);

}  // namespace sightline
