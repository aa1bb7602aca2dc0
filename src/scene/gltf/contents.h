#pragma once
// The names in a file that options can select. Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// The names of a top-level array's objects, such as scenes; empty for objects without a name.
std::vector<std::string> names_in(const Document& document, const char* list);

/// The variants of KHR_materials_variants.
std::vector<std::string> variant_names(const Document& document);

FileContents read_contents(const Document& document);

}  // namespace sightline
