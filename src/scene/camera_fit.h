#pragma once
#include "scene/scene.h"

#include <optional>
#include <span>
#include <string>

namespace sightline {

/// The default camera: a vertical field of view of 45°, looking at the centre of the bounds from
/// `direction` at distance radius / sin 22.5°, where radius is half the bounds' diagonal.
Camera fit_camera(const Box3& bounds, const Vec3& direction = {0.6f, 0.35f, 0.8f});

/// The direction from the scene to the camera of a named view: "fit" (the default direction),
/// "front" (+z, glTF's front), "back", "left", "right", "top", "bottom"; empty for other names.
std::optional<Vec3> view_direction(const std::string& name);

/// The names that view_direction knows.
std::span<const std::string> view_names();

/// A camera at `from` that looks at `at`; `yfov` in radians; `up` need not be orthogonal to the
/// view direction.
Camera look_at(const Vec3& from, const Vec3& at, const Vec3& up, float yfov);

}  // namespace sightline
