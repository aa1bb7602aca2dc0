#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// For each buffer, whether something in the file may read its bytes: primitives, skins, instances,
/// images, compressed streams and, if `animated`, animations. The others are placeholders, such as
/// compression leaves for what it replaces, and need not exist. Buffer views and accessors must
/// have been parsed.
std::vector<bool> needed_buffers(const Document& document, bool animated);

}  // namespace sightline
