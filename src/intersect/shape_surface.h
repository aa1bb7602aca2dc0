#pragma once
#include "core/math.h"
#include "scene/scene.h"

namespace sightline {

/// A point on a shape's surface, in the space of Shape::to_object's target.
struct ShapePoint {
    Vec3d position;
    Vec3d normal;   ///< unit, outwards
    Vec2 uv;        ///< sphere: longitude, latitude as in glTF (0,0 top left); plane, box: per face
    Vec3d tangent;  ///< unit, along growing u
};

/// The surface point at a hit, reprojected onto the surface in double precision. With
/// `parametrised` false, uv and tangent may be 0, which saves their arc functions.
ShapePoint shape_point(const Shape& shape, const Vec3d& near_surface, bool parametrised = true);

}  // namespace sightline
