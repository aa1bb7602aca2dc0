#pragma once
#include "scene/scene.h"
#include "scene/view_names.h"

namespace sightline {

/// A vertical field of view of 45°, looking at the centre of the bounds from distance
/// radius / sin 22.5°, where radius is half the bounds' diagonal.
Camera fit_camera(const Box3& bounds, const ViewAngles& angles = fit_view);

/// A camera at `from` that looks at `at`; `yfov` in radians; `up` need not be orthogonal to the
/// view direction.
Camera look_at(const Vec3& from, const Vec3& at, const Vec3& up, float yfov);

}  // namespace sightline
