#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// Reads, checks and parses a file and its buffers; meshopt and Draco data become plain buffer
/// views and accessors. Throws Error.
Document load_document(const std::string& path, const LoadOptions& options);

}  // namespace sightline
