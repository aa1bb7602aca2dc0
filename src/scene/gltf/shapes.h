#pragma once
// Analytic surfaces in glTF: KHR_implicit_shapes, which nodes refer to by
// SIGHTLINE_implicit_shapes (docs/shapes.md). Internal to src/scene.
#include "scene/gltf/document.h"

#include <optional>

namespace sightline {

/// The shape of a node, named after it, with identity matrices; its material is an index into
/// Scene::materials. None if it has a fault.
std::optional<Shape> node_shape(Document& document, uint32_t node);

/// Transforms a shape whose matrices are the identity. False if the matrix is singular.
bool transform_shape(Shape& shape, const Mat4d& to_object);

}  // namespace sightline
