#pragma once
// Whether a point lies inside a closed mesh.
#include "exact/triangle.h"
#include "scene/scene.h"

namespace sightline {

/// By the parity of the exact crossings of one ray; a ray that touches an edge or a vertex is
/// replaced by another, so that no crossing counts twice.
bool inside_by_parity(const Mesh& mesh, const Vec3& point);

/// The generalised winding number (Jacobson, Kavan and Sorkine-Hornung, Robust Inside-Outside
/// Segmentation using Generalized Winding Numbers, 2013): signed solid angles over 4π, 1 inside a
/// closed mesh whose triangles are counter-clockwise seen from outside, 0 outside, in between if
/// the mesh is open.
double winding_number(const Mesh& mesh, const Vec3& point);

}  // namespace sightline
