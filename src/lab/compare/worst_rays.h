#pragma once
// The rays that a report shows one by one, each with the cause of its errors.
#include "lab/compare/compare.h"

#include <nlohmann/json_fwd.hpp>

namespace sightline {

/// Why an answer is not the truth, or why the ray is shown although all answers are right, as the
/// name that results.json has: left_out, self_hit, shared, edge, grazing, inaccurate, other,
/// near_tie, undecidable, unjudged, largest_error. docs/compare.md says what they mean.
std::string cause_of(const Scene& scene, const RecordedRay& recorded, const Truth& truth,
                     const EngineAnswer& answer, const Engine& engine);

/// A few findings of each engine and verdict, and the rays with the largest errors of t, with the
/// truth, all answers and the cause; grouped by cause.
nlohmann::ordered_json worst_rays_json(const Comparison& comparison, const Scene& scene,
                                       const Referee& referee, std::span<const RecordedRay> rays,
                                       std::span<const Engine> engines);

}  // namespace sightline
