#pragma once
// A glTF primitive as a Mesh. Internal to src/scene.
#include "scene/gltf/document.h"

#include <optional>

namespace sightline {

/// The morph weights and skin of a node, for its mesh's primitives.
struct MeshPose {
    std::span<const float> weights;              ///< of morph targets; empty: all 0
    const std::vector<Mat4d>* joints = nullptr;  ///< of a skin, which yields world space
    Frame frame;                                 ///< of object space, for a mesh without skin
    Mat4d node_to_world;  ///< of a mesh with a skin, for primitives that do not follow its joints
};

/// A primitive with the bounds of all its vertices, in the frame of object space or, with a skin,
/// in world space. The mesh is empty if there are no triangles to draw.
struct PrimitiveMesh {
    Mesh mesh;
    Box3 bounds;
};

/// Reads a primitive: triangles from any of the triangle modes, unit normals, tangents if
/// `material` needs them. `source` is its JSON. Throws FaultyPart with `place`.
PrimitiveMesh read_primitive(Document& document, const GltfPrimitive& primitive,
                             const nlohmann::json& source, const std::string& place,
                             const Material& material, const MeshPose& pose);

/// Transforms a mesh by an affine matrix, normals by the inverse transpose; a mirroring matrix
/// reverses the winding, so that front faces stay counter-clockwise.
void transform_mesh(Mesh& mesh, const Mat4d& matrix);

/// The largest absolute coordinate in world space that is drawn: squares of distances stay finite,
/// and rays stay within the range that Embree can trace.
constexpr float max_coordinate = 1e18f;

/// Removes triangles with a coordinate that is NaN or beyond ±`limit`, and then unused vertices,
/// with a warning.
void drop_out_of_range_triangles(Document& document, Mesh& mesh, const std::string& place,
                                 float limit);

}  // namespace sightline
