#pragma once
// Meshes of the families.
#include "lab/atlas/rng.h"
#include "scene/scene.h"

namespace sightline {

/// A scene of baked meshes.
Scene scene_of_meshes(std::vector<Mesh> meshes);

/// Appends the triangles of a square grid of side × side cells, two a cell; the mesh has the
/// vertices, row by row.
void add_grid_triangles(Mesh& mesh, uint32_t side);

/// A bumpy square patch of side² cells around the origin, with edges of about length 1; `bumps`
/// scales its random heights. All triangles face +z. `transform` is applied before the vertices
/// are rounded to float.
Mesh bumpy_patch(uint32_t side, double bumps, const Mat4d& transform, Rng& rng);

/// A closed sphere of radius 1 with 2·n·(n−1) triangles that share their vertices, transformed
/// likewise.
Mesh closed_globe(uint32_t n, const Mat4d& transform);

Mat4d random_rotation(Rng& rng);

/// Scales about the origin, then translates.
Mat4d scale_and_translate(const Vec3d& scale, const Vec3d& offset);

enum class Target { inside, edge, vertex };

/// A vertex of a triangle, or a random point of an edge or of the whole triangle, in double: the
/// target of a ray, which the ray's floats can only approximate.
Vec3d random_target(const Mesh& mesh, uint32_t triangle, Target target, Rng& rng);

/// The same on a random triangle.
Vec3d random_target(const Mesh& mesh, Target target, Rng& rng);

}  // namespace sightline
