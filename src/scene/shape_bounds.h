#pragma once
#include "scene/scene.h"

namespace sightline {

/// The heart's extents at scale 1, rounded outwards: |x|, |z|, and y from −1.
inline constexpr double heart_x = 1.1391, heart_y = 1.2367, heart_z = 0.6782;

/// Bounds in the space of Shape::to_object's target; an endless plane is given ±1e6 extents.
Box3 shape_bounds(const Shape& shape);

/// True for planes without an end along x or z.
bool is_endless(const Shape& shape);

/// The box of a box that an affine matrix has transformed; of an empty box an empty one.
Box3 transformed_box(const Box3& box, const Mat4d& matrix);

}  // namespace sightline
