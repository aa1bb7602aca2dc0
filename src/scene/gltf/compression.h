#pragma once
// Compressed geometry made plain. Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// EXT_meshopt_compression: decodes each compressed buffer view into a buffer of its own, which
/// the view then shows. Views must have been parsed and buffers loaded; what fallback buffers hold
/// is not looked at. Throws Error.
void decode_meshopt(Document& document);

/// KHR_draco_mesh_compression: decodes each compressed primitive into buffer views of its own,
/// which its accessors then show. Meshes must have been parsed and buffers loaded. Throws Error,
/// also on more than `max_elements` indices.
void decode_draco(Document& document, uint64_t max_elements);

}  // namespace sightline
