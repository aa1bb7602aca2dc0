#pragma once
// Morph targets and skins. Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// For each joint of a skin, the matrix from mesh vertices to world space. The skin must have
/// passed check_skins.
std::vector<Mat4d> joint_matrices(const GltfSkin& skin, std::span<const Mat4d> node_to_world);

/// Adds the primitive's morph targets times `weights` (empty: all 0) to the positions, normals,
/// tangents, texture coordinates and colours that `posed` has; it must have the primitive's
/// vertices. `place` is the primitive's JSON path. Throws FaultyPart.
void morph(Document& document, const GltfPrimitive& primitive, std::span<const float> weights,
           const std::string& place, Mesh& posed);

/// Transforms the vertices to world space by the `joints`, blended by the primitive's JOINTS_n and
/// WEIGHTS_n (normalised to sum 1). Reverses the winding of triangles that the joints mirror.
/// `place` is the primitive's JSON path. Throws FaultyPart.
void skin(Document& document, const GltfPrimitive& primitive, std::span<const Mat4d> joints,
          const std::string& place, Mesh& posed);

}  // namespace sightline
