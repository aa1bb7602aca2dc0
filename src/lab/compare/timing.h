#pragma once
#include "lab/compare/compare.h"

namespace sightline {

/// Times the engines on rays of one kind, `which` into `rays`: runs of them spread over all, on
/// one thread, the engines taking turns. Fills ns_per_ray and instructions_per_ray of that kind.
void time_engines(std::span<const Engine> engines, std::span<const RecordedRay> rays,
                  std::span<const uint32_t> which, const CompareOptions& options,
                  std::vector<EngineScore>& scores);

}  // namespace sightline
