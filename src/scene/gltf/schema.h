#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// Makes document.json obey gltf_rules(): no property has a wrong type, is missing, is not one of
/// its allowed values, or is an index out of range. What does is reported and left out: a property,
/// or the object that it decides; an object in a list becomes one that shows nothing. Replaces
/// integers written as 3.0 by integers. Returns whether the JSON is still that of the file. Throws
/// Error where nothing is left to read.
bool check_structure(Document& document);

}  // namespace sightline
