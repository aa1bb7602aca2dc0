#pragma once
#include "lab/compare/compare.h"

namespace sightline {

/// Times the engines on one thread, in turns, with the rays at `indices`, all of one kind: waves
/// spread evenly over them. Sets ns_per_ray, instructions_per_ray and wrapper of that kind in
/// `scores`.
void time_engines(std::span<const Engine> engines, std::span<const RecordedRay> rays,
                  std::span<const uint32_t> indices, const CompareOptions& options,
                  std::vector<EngineScore>& scores);

}  // namespace sightline
