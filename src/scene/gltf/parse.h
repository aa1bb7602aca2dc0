#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// Sets buffer views, accessors, meshes, nodes, skins and animations from the document's JSON,
/// which check_structure must have accepted. Throws Error.
void parse_model(Document& document);

}  // namespace sightline
