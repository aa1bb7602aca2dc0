#pragma once
// What a file offers to choose from. Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// The names of a top-level array's objects, such as scenes; empty ones where they have none.
std::vector<std::string> names_in(const Document& document, const char* list);

/// The names of KHR_materials_variants, in the file's order.
std::vector<std::string> variant_names(const Document& document);

FileContents read_contents(const Document& document);

}  // namespace sightline
