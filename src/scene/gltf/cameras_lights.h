#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// The cameras of the `nodes` in world space, `world` being the matrices of all nodes. One with an
/// impossible lens has a `fault`.
std::vector<Camera> read_cameras(Document& document, const std::vector<uint32_t>& nodes,
                                 const std::vector<Mat4d>& world);

/// The same for lights (KHR_lights_punctual). Warns of values that are out of range.
std::vector<Light> read_lights(Document& document, const std::vector<uint32_t>& nodes,
                               const std::vector<Mat4d>& world);

}  // namespace sightline
