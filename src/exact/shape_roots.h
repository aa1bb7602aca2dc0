#pragma once
// The roots of a ray in a shape as comparable numbers. Private to src/exact.
#include "exact/real_root.h"
#include "exact/shapes.h"

namespace sightline {

/// As `exact_roots`.
std::optional<std::vector<RealRoot>> shape_roots(const Ray& ray, const PlacedShape& shape);

}  // namespace sightline
