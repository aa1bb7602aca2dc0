#pragma once
// The crossings of a ray and a shape as comparable numbers. Private to src/exact.
#include "exact/real_root.h"
#include "exact/shapes.h"
#include "exact/triangle.h"

namespace sightline {

/// Like `exact_roots`.
std::optional<std::vector<RealRoot>> shape_roots(const Ray& ray, const InstancedShape& shape);

/// The root of a sphere that enclose_sphere_roots has found.
RealRoot sphere_root(const Ray& ray, const InstancedShape& sphere, const Enclosure& t);

}  // namespace sightline
