#pragma once
// Nodes and meshes as they stand at one moment. Internal to src/scene.
#include "scene/gltf/document.h"

namespace sightline {

/// Sets the nodes' translation, rotation, scale and weights to what the animations say at `time`
/// (seconds, held before the first and after the last key). `which` is a name, an index or "all";
/// of several animations of one property the last counts. Throws Error.
void animate(Document& document, const std::string& which, double time);

/// The matrices from a skinned mesh's vertices to world space, one a joint, given the nodes'.
/// Throws Error.
std::vector<Mat4d> joint_matrices(const Document& document, uint32_t skin,
                                  std::span<const Mat4d> node_to_world);

/// Adds the primitive's morph targets times `weights` (none: all 0) to the positions, normals and
/// tangents of `posed`, whose vertices must be those of the primitive. `place` is the primitive's
/// JSON path. Throws Error.
void morph(const Document& document, const GltfPrimitive& primitive, std::span<const float> weights,
           const std::string& place, Mesh& posed);

/// Moves the vertices to world space, blending `joints` by the primitive's JOINTS_n and WEIGHTS_n
/// (made to sum to 1); triangles that the joints mirror are turned round. `place` is the
/// primitive's JSON path. Throws Error.
void skin(const Document& document, const GltfPrimitive& primitive, std::span<const Mat4d> joints,
          const std::string& place, Mesh& posed);

}  // namespace sightline
