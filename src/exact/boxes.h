#pragma once
#include "core/ray.h"

namespace sightline {

/// True if the closed box min ≤ p ≤ max has a point of the valid ray's segment, ends included.
/// Exact; a box with min > max is empty.
bool exact_box_crossing(const Ray& ray, const Box3& box);

}  // namespace sightline
