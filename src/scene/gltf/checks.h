#pragma once
#include "scene/gltf/document.h"

namespace sightline {

/// Throws Error with the JSON path where a property that is read anywhere has the wrong type, is
/// missing, is not one of its allowed values, or is an index out of range. Numbers such as 3.0
/// become the integers that they stand for.
void check_structure(Document& document);

/// Throws Error on a version other than 2.x and on a required extension that is not known here;
/// warns of unknown ones that are merely used.
void check_version_and_extensions(Document& document);

/// Throws Error where buffer views leave their buffers, or accessors their views, or are larger
/// than `max_elements`.
void check_accessors(const Document& document, uint64_t max_elements);

/// Fills the nodes' parents. Throws Error on a node with two parents and on cycles.
void check_tree(Document& document);

/// Throws Error where an animation's channels name samplers that it has not.
void check_animations(const Document& document);

}  // namespace sightline
