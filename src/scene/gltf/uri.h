#pragma once
// Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// The bytes that a URI refers to: a data URI, or a percent-encoded path relative to the
/// document's folder, which it may leave only with `allow_outside`. Records files in the document,
/// and reports at `place` what had to be mended. Returns nothing if there is no such file, and says
/// why in `problem`. Throws LimitError if it is too large.
std::optional<FileBytes> read_uri(Document& document, const std::string& uri,
                                  const std::string& place, const LoadOptions& options,
                                  std::string& problem);

/// The paths that the URIs of the document's buffers and images name, whether the files exist or
/// not.
std::vector<std::string> named_files(const Document& document);

}  // namespace sightline
