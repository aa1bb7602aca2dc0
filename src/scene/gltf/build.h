#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// The scene that `options` selects, from a document whose nodes have been posed. Throws Error.
Scene build_scene(Document& document, const LoadOptions& options);

}  // namespace sightline
