#pragma once
// Exact intersection of a ray and an analytic shape.
#include "core/ray.h"
#include "scene/scene.h"

#include <optional>
#include <vector>

namespace sightline {

/// A shape as the scene defines it: its equation in its own space, the matrix to that space
/// (Shape::to_shape) and the instance's matrix are all taken as exact.
struct InstancedShape {
    const Shape* shape = nullptr;    ///< not owned
    const Mat4* to_world = nullptr;  ///< affine; none: the identity; not owned
};

/// A point at which the ray crosses the surface, or touches it (even multiplicity).
struct ExactRoot {
    double t;  ///< the nearest double
    int multiplicity;
};

/// All roots in tnear < t ≤ tfar, ascending. A face or mantle that contains the ray has no root;
/// the ray then crosses the rims of the other parts. Returns nullopt if there is no exact answer,
/// because the matrix has no inverse.
std::optional<std::vector<ExactRoot>> exact_roots(const Ray& ray, const InstancedShape& shape);

/// A box in world space outside of which the shape has no point, tight to within a few ulps for
/// spheres and shapes whose axes are those of the world; without end for an endless plane, and
/// where exact_roots has no answer.
Box3 exact_bounds(const InstancedShape& shape);

}  // namespace sightline
