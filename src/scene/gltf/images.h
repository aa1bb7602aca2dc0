#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// Fills Scene::images: decodes, in parallel, the images of the materials marked as used; the
/// others stay empty. Images of equal content are decoded once: textures then refer to the first.
/// Reports images that are missing or damaged, or that are KTX2, and removes the references to
/// them from the materials, unless a checker takes their place. Throws LimitError if an image or
/// all of them together are too large.
void decode_images(Document& document, const std::vector<bool>& material_used,
                   const LoadOptions& options, Scene& scene);

/// Decodes all images of the file, and reports those that are missing or damaged, or that are KTX2.
/// Throws LimitError as decode_images does.
void check_images(Document& document, const LoadOptions& options);

}  // namespace sightline
