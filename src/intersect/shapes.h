#pragma once
// Ray against one analytic shape, in double precision, with the origin moved to the point of the
// ray that is closest to the shape's centre.
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

}  // namespace sightline
