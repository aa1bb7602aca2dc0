#pragma once
// The crossings of a ray and a shape as comparable numbers. Private to src/exact.
#include "exact/real_root.h"
#include "exact/shapes.h"

namespace sightline {

/// Like `exact_roots`.
std::optional<std::vector<RealRoot>> shape_roots(const Ray& ray, const InstancedShape& shape);

}  // namespace sightline
