#pragma once
#include "scene/scene.h"

namespace sightline {

/// The default camera: 45° vertical field of view, looking at the centre of the bounds from
/// direction (0.6, 0.35, 0.8), at distance radius / sin 22.5°, radius = half the bounds' diagonal.
Camera fit_camera(const Box3& bounds);

/// A free camera: `yfov` in radians; `up` need not be orthogonal to the view.
Camera look_at(const Vec3& from, const Vec3& at, const Vec3& up, float yfov);

}  // namespace sightline
