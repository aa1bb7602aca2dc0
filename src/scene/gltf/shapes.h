#pragma once
// Analytic surfaces in glTF: KHR_implicit_shapes, placed by SIGHTLINE_implicit_shapes
// (docs/shapes.md). Internal to src/scene.
#include "scene/gltf/document.h"

#include <optional>

namespace sightline {

/// The surface that a node carries; its matrices are the identity, its material counts glTF's
/// materials from 1 as Scene does, its name is the node's. Throws Error.
std::optional<Shape> node_shape(const Document& document, uint32_t node);

/// Puts the shape into another space. False where the matrix is singular.
bool place_shape(Shape& shape, const Mat4d& to_object);

}  // namespace sightline
