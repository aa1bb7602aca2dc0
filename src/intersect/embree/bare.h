#pragma once
#include "core/ray.h"
#include "intersect/embree/embree_api.h"

#include <span>

namespace sightline {

/// Has Embree trace the rays as its own user would: they are transposed into packets of sixteen, or
/// copied one by one, and its answers stay where it puts them. What our intersector is timed
/// against.
void trace_bare(RTCScene scene, Query& query, std::span<const Ray> rays, bool any_hit,
                bool packets);

}  // namespace sightline
