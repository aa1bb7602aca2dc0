#pragma once
#include "scene/gltf/document.h"

namespace sightline {

/// Fills views, accessors, meshes, nodes, skins and animations from the document's JSON, whose
/// structure must have been checked. Throws Error.
void parse_model(Document& document);

}  // namespace sightline
