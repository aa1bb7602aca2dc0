#pragma once
#include "scene/gltf/load_options.h"
#include "scene/scene.h"

namespace sightline {

/// Loads a .gltf or .glb file (recognised by content), posed at `options.time`. Throws Error with
/// file, JSON path and reason if the file violates the specification in a way that affects
/// rendering; other deviations become lines of Scene::warnings.
Scene load_gltf(const std::string& path, const LoadOptions& options = {});

}  // namespace sightline
