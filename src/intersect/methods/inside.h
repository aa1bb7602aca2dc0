#pragma once
// Inside or outside of a closed mesh.
#include "exact/triangle.h"
#include "scene/scene.h"

namespace sightline {

/// By parity of the crossings of one ray, counted exactly; a ray that touches an edge or a vertex
/// is replaced by another, so that no crossing counts twice.
bool inside_by_parity(const Mesh& mesh, const Vec3& point);

/// The generalised winding number (Jacobson, Kavan and Sorkine-Hornung, Robust Inside-Outside
/// Segmentation using Generalized Winding Numbers, 2013): signed solid angles over 4π, 1 within a
/// closed mesh whose triangles turn counter-clockwise outside, 0 without, between where it is open.
double winding_number(const Mesh& mesh, const Vec3& point);

}  // namespace sightline
