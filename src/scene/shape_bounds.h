#pragma once
#include "scene/scene.h"

namespace sightline {

/// The heart's extents at scale 1, rounded outwards: |x|, |z|, and y from −1.
inline constexpr double heart_x = 1.1391, heart_y = 1.2367, heart_z = 0.6782;

/// Bounds in shape space, before to_object; no part of the surface lies outside by more than the
/// rounding of a double. Endless planes get extents of ±1e6.
Imath::Box3d shape_space_bounds(const Shape& shape);

/// Bounds in object space; endless planes get extents of ±1e6.
Box3 shape_bounds(const Shape& shape);

/// Bounds of all vertices, in object space.
Box3 mesh_bounds(const Mesh& mesh);

/// Whether the shape is a plane that is infinite along x or z.
bool is_endless(const Shape& shape);

/// The bounds of a box transformed by an affine matrix; empty if the box is empty.
Box3 transformed_box(const Box3& box, const Mat4d& matrix);

}  // namespace sightline
