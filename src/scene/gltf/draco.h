#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// KHR_draco_mesh_compression: decodes each compressed primitive into new buffer views, to which
/// its accessors then refer. Meshes must have been parsed and buffers loaded. Drops primitives that
/// cannot be decoded. Throws Error on more than `max_elements` indices.
void decode_draco(Document& document, uint64_t max_elements);

}  // namespace sightline
