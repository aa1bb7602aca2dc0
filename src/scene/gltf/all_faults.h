#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// Reports the faults of everything that the file holds and a picture may need: each scene, each
/// material of a variant, morph targets at any weight, each animation and each image. Images are
/// decoded within the limits of `options`. The nodes must be at rest. Throws Error as load_gltf
/// does.
void report_all_faults(Document& document, const LoadOptions& options);

}  // namespace sightline
