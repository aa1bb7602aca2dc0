#pragma once
#include "core/ray.h"

#include <compare>

namespace sightline {

/// A triangle or a shape, by the indices of a Hit.
struct SurfaceId {
    uint32_t instance = none, geometry = none, primitive = none;

    auto operator<=>(const SurfaceId&) const = default;
};

inline SurfaceId surface_of(const Hit& hit) { return {hit.instance, hit.geometry, hit.primitive}; }

}  // namespace sightline
