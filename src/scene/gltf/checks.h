#pragma once
// Checks that span several properties. Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// Throws Error on a version other than 2.x and on a required extension that is not supported;
/// warns of unsupported extensions that are used but not required.
void check_version_and_extensions(Document& document);

/// Throws Error if a buffer view exceeds its buffer, or an accessor its view or `max_elements`.
void check_accessors(const Document& document, uint64_t max_elements);

/// Sets the nodes' parents. Throws Error on a node with two parents and on cycles.
void check_tree(Document& document);

/// Throws Error if an animation channel's sampler index is out of range.
void check_animations(const Document& document);

}  // namespace sightline
