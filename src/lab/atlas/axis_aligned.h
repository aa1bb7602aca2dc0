#pragma once
// Family T7: rays and triangles along the axes, where products are exactly zero.
#include "lab/atlas/scene_trial.h"

#include <span>
#include <string_view>

namespace sightline {

/// What the cases are, in order.
std::span<const std::string_view> axis_aligned_cases();

/// The queries of case `which`.
SceneQueries axis_aligned(size_t which, size_t rays, uint64_t seed);

}  // namespace sightline
