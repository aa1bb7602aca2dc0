#pragma once
// KHR_lights_punctual. Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// The lights of the `nodes` in world space, `world` being the matrices of all nodes. Warns of
/// values that are out of range.
std::vector<Light> read_lights(Document& document, const std::vector<uint32_t>& nodes,
                               const std::vector<Mat4d>& world);

}  // namespace sightline
