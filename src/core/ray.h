#pragma once
#include "core/math.h"

#include <limits>

namespace sightline {

/// The points origin + t·direction with tnear < t ≤ tfar, in world space. The direction need not
/// have unit length; tnear ≥ 0.
struct Ray {
    Vec3 origin;
    float tnear = 0;
    Vec3 direction;
    float tfar = std::numeric_limits<float>::infinity();
};

/// The closest intersection along a ray; a miss if `geometry == none`.
struct Hit {
    float t = std::numeric_limits<float>::infinity();
    float u = 0, v = 0;         ///< barycentric coordinates of the second and third vertex
    uint32_t primitive = none;  ///< triangle within the mesh; 0 for a shape
    uint32_t geometry = none;   ///< index into Scene::meshes, then (past their end) Scene::shapes
    uint32_t instance = none;   ///< index into Scene::instances

    explicit operator bool() const { return geometry != none; }
};

}  // namespace sightline
