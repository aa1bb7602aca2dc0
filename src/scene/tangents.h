#pragma once
#include "scene/scene.h"

namespace sightline {

/// Gives every triangle its own three vertices with its geometric normal.
void compute_flat_normals(Mesh& mesh);

/// Tangents by MikkTSpace's rules (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited")
/// from normals and texture coordinate set `texcoord`, which the mesh must have; the bitangent
/// cross(normal, tangent) · w points against v, as glTF's normal textures require. Vertices that
/// need two tangents are duplicated.
void compute_tangents(Mesh& mesh, uint32_t texcoord);

}  // namespace sightline
