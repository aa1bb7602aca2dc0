#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// EXT_meshopt_compression: decodes each compressed buffer view into a new buffer, to which the
/// view then refers. Views must have been parsed and buffers loaded; the contents of fallback
/// buffers are ignored. Throws Error.
void decode_meshopt(Document& document);

}  // namespace sightline
