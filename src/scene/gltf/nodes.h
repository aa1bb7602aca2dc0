#pragma once
// The node hierarchy in world space. Internal to src/scene; the atlas also uses world_matrices.
#include "scene/gltf/document.h"

namespace sightline {

/// A node's local transform: scale, then rotation, then translation.
Mat4d local_matrix(const GltfNode& node);

/// Each node's matrix to world space, composed in double, also of nodes outside the scene. Drops
/// nodes whose matrix is not finite.
std::vector<Mat4d> world_matrices(Document& document);

/// The unit direction in world space of a node's `axis`; `axis` itself if a scale of 0 leaves no
/// direction.
Vec3d world_axis(const Mat4d& world, const Vec3d& axis);

/// The visible nodes of the chosen scene, parents before children. Throws Error if there is no
/// such scene.
std::vector<uint32_t> visible_nodes(Document& document, const LoadOptions& options);

/// The scene's own constant background (SIGHTLINE_background, docs/background.md).
std::optional<Vec3> scene_background(Document& document, const LoadOptions& options);

/// The matrices to world space of a node's mesh or shape: `world`, or one for each instance of
/// EXT_mesh_gpu_instancing.
std::vector<Mat4d> instance_matrices(Document& document, uint32_t node, const Mat4d& world);

}  // namespace sightline
