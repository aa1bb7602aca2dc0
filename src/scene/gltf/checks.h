#pragma once
// Checks that span several properties. Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// Checks asset.version of any JSON. Throws Error on glTF 1.0, on versions above 2.x and if there
/// is none.
void check_version(Document& document);

/// Throws Error if asset.minVersion is above 2.0.
void check_minimum_version(Document& document);

/// Reports extensions that are not read. Throws Error if one is required that may hide geometry or
/// bytes.
void check_extensions(Document& document);

/// Empties, with a report, buffer views that exceed their buffer and accessors that exceed their
/// view. Throws Error if an accessor exceeds `max_elements`.
void check_accessors(Document& document, uint64_t max_elements);

/// Sets the nodes' parents and makes them a forest: leaves out second parents and cycles.
void check_tree(Document& document);

/// Takes skins without joints, or without a matrix for each joint, from the nodes that have them.
void check_skins(Document& document);

/// Takes the target from animation channels without sampler.
void check_animations(Document& document);

}  // namespace sightline
