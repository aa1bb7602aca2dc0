#pragma once
// The geometry that a comparison judges, for engines of other programs.
#include "scene/scene.h"

namespace sightline {

/// Writes the triangles as they are judged, in the format that docs/engines.md describes: the
/// vertices that the program stores and, for each instance, the float matrix to world space. Shapes
/// are no triangles and are left out. Throws Error.
void write_triangles(const std::string& path, const Scene& scene);

/// The same scene with a mesh of its own for each mesh of each instance, whose vertices are rounded
/// to floats in world space, as most engines store them. The ids of instances stay (the shapes of
/// an instance follow as one more), those of geometries change.
Scene flatten(const Scene& scene);

}  // namespace sightline
