#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// Checks document.json against gltf_rules(). Throws Error with the JSON path of a property that
/// has the wrong type, is missing, is not one of its allowed values, or is an index out of range.
/// Replaces integers written as 3.0 by integers.
void check_structure(Document& document);

}  // namespace sightline
