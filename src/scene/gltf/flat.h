#pragma once
// Matrices that flatten what they transform. Internal to src/scene.
#include "core/math.h"

namespace sightline {

/// How much more a matrix stretches one direction than another, at most: ‖M‖·‖M⁻¹‖ of the linear
/// part in Frobenius' norm, and thus 3 at least. Infinite or NaN if there is no inverse.
double condition_of(const Mat4d& matrix);

/// Whether the matrix keeps some area: false if it scales everything to a line or a point.
bool has_area(const Mat4d& matrix);

/// A singular matrix that keeps some area, changed such that what it scaled to a plane becomes 2⁻¹⁶
/// as thick as it is wide: no pixel shows that, and the matrix has an inverse.
Mat4d thickened(const Mat4d& matrix);

}  // namespace sightline
