#pragma once
// Meshes of simple shapes, for scenes made in code.
#include "scene/scene.h"

namespace sightline {

/// A parallelogram with corner `a` and edges `u`, `v`; its front is the side of cross(u, v).
/// Texture coordinates are (0, 0) at `a` and (1, 1) opposite.
Mesh quad_mesh(const Vec3& a, const Vec3& u, const Vec3& v);

/// A closed sphere with its poles along y: `rows` ≥ 2 bands of latitude, `columns` ≥ 3 sectors,
/// 2·columns·(rows − 1) triangles that share their vertices, unit normals.
Mesh sphere_mesh(uint32_t rows, uint32_t columns, const Vec3& centre = {0, 0, 0}, float radius = 1);

}  // namespace sightline
