#pragma once
// The node hierarchy in world space. Internal to src/scene; the laboratory puts it to the test.
#include "scene/gltf/document.h"

namespace sightline {

/// A node's own transform: first scaled, then rotated, then translated.
Mat4d local_matrix(const GltfNode& node);

/// Each node's matrix to world space, composed in double; nodes need not belong to a scene.
/// Throws Error where one is not finite.
std::vector<Mat4d> world_matrices(const Document& document);

/// The nodes of the scene that `options` chooses which are to be drawn, parents before children.
/// Throws Error where there is no such scene.
std::vector<uint32_t> visible_nodes(Document& document, const LoadOptions& options);

/// Adds the cameras and lights of the nodes to the scene.
void place_cameras_and_lights(Document& document, const std::vector<uint32_t>& nodes,
                              const std::vector<Mat4d>& world, Scene& scene);

/// The scene's own constant background (SIGHTLINE_background, docs/background.md).
std::optional<Vec3> scene_background(Document& document, const LoadOptions& options);

/// Where a node's mesh stands: once, or for each instance of EXT_mesh_gpu_instancing.
std::vector<Mat4d> placements(const Document& document, uint32_t node, const Mat4d& world);

}  // namespace sightline
