#pragma once
#include "scene/scene.h"

namespace sightline {

/// The point of a shape, in its own space, that lies farthest along `direction` (any length but
/// zero). Of an endless plane: of the part within ±1e6. Exact, but for hearts, where it is within
/// 1e-4 of their size.
Vec3d farthest_point(const Shape& shape, const Vec3d& direction);

}  // namespace sightline
