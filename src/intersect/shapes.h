#pragma once
// Ray against one analytic shape, in double precision on an origin shifted to the closest approach.
#include "core/ray.h"
#include "scene/scene.h"
#include "scene/shape_bounds.h"

namespace sightline {

/// Up to six roots t of the ray against the shape's whole surface within [tnear, tfar], ascending.
struct ShapeRoots {
    int count = 0;
    double t[6];
};

/// All crossings of the ray (in the space of Shape::to_object's target) with the shape.
ShapeRoots intersect_shape(const Shape& shape, const Vec3d& origin, const Vec3d& direction,
                           double tnear, double tfar);

/// Where a ray met the shape: the point is put back onto the surface (reprojected) in double.
struct ShapePoint {
    Vec3d position;  ///< in the space of Shape::to_object's target
    Vec3d normal;    ///< unit, outwards
    Vec2 uv;         ///< sphere: longitude, latitude as glTF (0,0 top left); plane, box: per face
    Vec3d tangent;   ///< unit, along growing u
};
/// `parametrised` false spares the arc functions of uv, and may leave it and the tangent 0.
ShapePoint shape_point(const Shape& shape, const Vec3d& near_surface, bool parametrised = true);

}  // namespace sightline
