#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// Fills Scene::images: decodes, in parallel, the images of the materials marked as used; the
/// others stay empty. Removes references to KTX2 images from the materials, with a warning. Throws
/// Error for the first image that cannot be decoded.
void decode_images(Document& document, const std::vector<bool>& material_used,
                   const LoadOptions& options, Scene& scene);

}  // namespace sightline
