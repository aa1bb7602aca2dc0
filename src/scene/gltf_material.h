#pragma once
#include "scene/gltf_document.h"

#include <functional>

namespace sightline {

/// Fills Scene::materials (glTF's default first, so material i is at i + 1) and Scene::textures.
/// What cannot be drawn as meant becomes a warning of the document.
void read_materials(Document& document, Scene& scene);

/// Calls `visit` with each texture reference of a material.
void for_each_texture(const Material& material,
                      const std::function<void(const TextureRef&)>& visit);
void for_each_texture(Material& material, const std::function<void(TextureRef&)>& visit);

/// Decodes, in parallel, the images that the marked materials use; the others stay empty.
/// Throws Error of the first image that cannot be decoded.
void decode_images(Document& document, const std::vector<bool>& material_used,
                   const LoadOptions& options, Scene& scene);

}  // namespace sightline
