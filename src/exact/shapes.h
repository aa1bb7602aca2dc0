#pragma once
// The referee on ray and analytic shape.
#include "core/ray.h"
#include "scene/scene.h"

#include <optional>
#include <vector>

namespace sightline {

/// A shape as the scene states it: in its own space its equation holds exactly, and exact are the
/// matrix that leads there (Shape::to_shape) and that of its instance.
struct PlacedShape {
    const Shape* shape = nullptr;    ///< not owned
    const Mat4* to_world = nullptr;  ///< affine; none: the identity; not owned
};

/// A crossing or touching of the ray with a surface; the multiplicity is even where it touches.
struct ExactRoot {
    double t;  ///< the nearest double
    int multiplicity;
};

/// All that lies in tnear < t ≤ tfar, ascending. A face or mantle within which the ray runs is not
/// crossed by it: it meets the rims of others. Nothing where the referee has no exact answer: the
/// matrix has no inverse.
std::optional<std::vector<ExactRoot>> exact_roots(const Ray& ray, const PlacedShape& shape);

}  // namespace sightline
