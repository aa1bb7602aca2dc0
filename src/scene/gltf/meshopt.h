#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// The object of EXT_meshopt_compression, or of KHR_meshopt_compression, which has the same form
/// and bitstream, of a buffer view's JSON, or nullptr.
const nlohmann::json* find_meshopt(const nlohmann::json& buffer_view);

/// Decodes each compressed buffer view into a new buffer, to which the view then refers. Views must
/// have been parsed and buffers loaded; the contents of fallback buffers are ignored. Drops views
/// that cannot be decoded.
void decode_meshopt(Document& document);

}  // namespace sightline
