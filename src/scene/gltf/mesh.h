#pragma once
// A glTF primitive as a Mesh. Internal to src/scene.
#include "scene/gltf/document.h"

#include <optional>

namespace sightline {

/// How the primitives of one node are to be read.
struct MeshPose {
    std::span<const float> weights;              ///< of morph targets; none: all 0
    const std::vector<Mat4d>* joints = nullptr;  ///< of a skin: the mesh comes out in world space
};

/// A primitive with the bounds of all its vertices, in the space that the pose says. The mesh is
/// empty where there are no triangles to draw.
struct PrimitiveMesh {
    Mesh mesh;
    Box3 bounds;
};

/// Reads a primitive: triangles from any of the triangle modes, unit normals, tangents where
/// `material` needs them. Throws Error with `place`.
PrimitiveMesh read_primitive(Document& document, const GltfPrimitive& primitive,
                             const std::string& place, const Material& material,
                             const MeshPose& pose);

/// Moves a mesh by an affine matrix: normals by the inverse transpose; a mirroring matrix swaps
/// the winding, so that front faces stay counter-clockwise.
void transform_mesh(Mesh& mesh, const Mat4d& matrix);

/// Coordinates in world space up to which meshes are drawn: squares of distances stay finite, and
/// rays keep within what Embree can trace.
constexpr float farthest = 1e18f;

/// Leaves out the triangles with a coordinate that is NaN or beyond ±`limit`, and the vertices that
/// no triangle uses any more, with a warning.
void leave_out_far_triangles(Document& document, Mesh& mesh, const std::string& place, float limit);

}  // namespace sightline
