#pragma once
#include "scene/scene.h"
#include "scene/scene_extent.h"
#include "scene/view_names.h"

#include <functional>

namespace sightline {

/// The point of what is to be framed that reaches farthest.
using FarthestPoint = std::function<Vec3d(const Reach&)>;

/// How a view frames what is in it.
struct Framing {
    ViewAngles angles = fit_view;
    bool orthographic = false;
    float yfov = pi / 4;   ///< radians, of perspective cameras
    float aspect = 1;      ///< width/height of the picture
    float margin = 0.05f;  ///< of the picture's width and height, left free on each side
    /// Set: for a full turn of the camera about the vertical axis through this point.
    std::optional<Vec3> turn_axis;
};

/// The camera that looks along the view and whose picture, up to the margin, is filled in width or
/// height; what is framed lies in its middle. Solved for the extents in the picture: exact up to
/// rounding. Points that have no extent in the picture are looked at from a distance.
Camera frame_camera(const FarthestPoint& farthest, const Framing& framing);

/// The points of `scene` that frame_camera needs so that it frames several scenes together, such as
/// the frames of an animation: nothing of them is cut, and they lie in the middle up to the
/// rounding of 16 steps.
std::vector<Vec3d> framing_points(const SceneExtent& scene, const Framing& framing);

/// The view that `fit-sphere` gives: a vertical field of view of 45°, looking at the centre of the
/// bounds from distance radius / sin 22.5°, where radius is half the bounds' diagonal.
Camera fit_camera(const Box3& bounds, const ViewAngles& angles = fit_view);

/// A camera at `from` that looks at `at`; `yfov` in radians; `up` need not be orthogonal to the
/// view direction.
Camera look_at(const Vec3& from, const Vec3& at, const Vec3& up, float yfov);

}  // namespace sightline
