#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// Sets the nodes' translation, rotation, scale and weights to their animated values at `time`
/// (seconds, clamped to the first and last keyframe). `which` is a name, an index or "all"; if
/// several animations target a property, the last wins. Throws Error.
void animate(Document& document, const std::string& which, double time);

}  // namespace sightline
