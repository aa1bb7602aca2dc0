#pragma once
// Meshes and scenes that the families are made of.
#include "lab/atlas/dice.h"
#include "scene/scene.h"

namespace sightline {

/// A scene of baked meshes, or of their shared group placed by each of the matrices.
Scene scene_of_meshes(std::vector<Mesh> meshes, const std::vector<Mat4d>& placed = {});

/// The triangles of a square grid of side × side cells, two a cell, over its vertices row by row.
void add_cells(Mesh& mesh, uint32_t side);

/// A bumpy square patch of side cells², with edges of about length 1, around the origin; all
/// triangles are seen from +z, and the vertices are rounded to float after `turn` has moved them.
Mesh bumpy_patch(uint32_t side, double bumps, const Mat4d& turn, Dice& dice);

/// A closed sphere of radius 1 in 2·n·(n−1) triangles that share their vertices, moved likewise.
Mesh closed_globe(uint32_t n, const Mat4d& turn);

/// A random rotation.
Mat4d random_rotation(Dice& dice);

/// Moves by scale about the origin, then by offset.
Mat4d scale_and_offset(const Vec3d& scale, const Vec3d& offset);

enum class Target { inside, edge, vertex };

/// A point of the mesh' triangle: a vertex, of its edge, or anywhere in it. In double: it is where
/// a ray should go, not quite where its floats can.
Vec3d aimed_point(const Mesh& mesh, uint32_t triangle, Target aim, Dice& dice);

/// The same of a random triangle.
Vec3d aimed_point(const Mesh& mesh, Target aim, Dice& dice);

}  // namespace sightline
