#pragma once
#include "core/ray.h"

namespace sightline {

enum class RayKind : uint32_t { camera, shadow, reflection, refraction };
inline constexpr size_t ray_kinds = 4;
inline constexpr const char* ray_kind_names[] = {"camera", "shadow", "reflection", "refraction"};

/// A ray as it was traced, for replay.
struct RecordedRay {
    Ray ray;
    RayKind kind;
    int x = -1, y = -1;  ///< the pixel that it was traced for; negative: unknown
};

}  // namespace sightline
