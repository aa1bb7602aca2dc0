#pragma once
#include "scene/gltf/document.h"

namespace sightline {

/// Fills Scene::materials (glTF's default first, so material i is at i + 1) and Scene::textures.
/// What cannot be drawn as meant becomes a warning of the document.
void read_materials(Document& document, Scene& scene);

/// Decodes, in parallel, the images that the marked materials use; the others stay empty.
/// Throws Error of the first image that cannot be decoded.
void decode_images(Document& document, const std::vector<bool>& material_used,
                   const LoadOptions& options, Scene& scene);

}  // namespace sightline
