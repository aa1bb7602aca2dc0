#pragma once
// Internal to src/scene.
#include "scene/gltf/placement.h"

namespace sightline {

/// The scene that `options` selects, from a document whose nodes have been posed, in the
/// frame of `placement`. Throws Error.
Scene build_scene(Document& document, const LoadOptions& options, const Placement& placement);

}  // namespace sightline
