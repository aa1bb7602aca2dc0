#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

#include <string_view>

namespace sightline {

/// Sets buffer views, accessors, meshes, nodes, skins and animations from the document's JSON,
/// which check_structure must have accepted. `text` is that of the file if the JSON is still what
/// it says, or else empty. Throws Error.
void parse_model(Document& document, std::string_view text);

}  // namespace sightline
