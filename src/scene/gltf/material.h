#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// The file's textures with their samplers. Warns of textures without a supported image.
std::vector<Texture> read_textures(Document& document);

/// glTF's default material, then the file's: glTF's material i is at i + 1. Warns of properties
/// that are out of range or cannot be rendered.
std::vector<Material> read_materials(Document& document, const std::vector<Texture>& textures);

}  // namespace sightline
