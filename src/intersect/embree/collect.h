#pragma once
// Queries that collect all they find.
#include "core/ray.h"
#include "intersect/embree/embree_api.h"

namespace sightline {

/// A filter for Query::collect: collects the hits and rejects them, so that the search goes on.
void collect_hits(const RTCFilterFunctionNArguments* args);

/// Collects the primitives, without their t, u and v, whose bounds come within `radius` of a point.
/// False if there are more than `most`.
bool collect_nearby(RTCScene scene, const Vec3& centre, float radius, size_t most,
                    std::vector<EngineHit>& found);

}  // namespace sightline
