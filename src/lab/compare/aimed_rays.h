#pragma once
#include "intersect/ray_file.h"

#include <string_view>

namespace sightline {

/// Where methods in floats fail.
enum class AimedAt {
    vertices,
    edges,
    silhouettes,  ///< edges between a triangle that faces the ray's origin and one that does not
    surface       ///< rays that leave a point of the surface, as secondary rays do
};
inline constexpr const char* aim_names[] = {"vertices", "edges", "silhouettes", "surface"};

/// `count` rays, shared evenly by the aims. Origins lie in the box around the scene's triangles, or
/// up to its size outside. Of rays aimed at edges and vertices every fourth is a shadow ray that
/// ends beyond the target; the others are reflection rays. The same for the same seed. Throws Error
/// if the scene has no triangles with an area.
std::vector<RecordedRay> aimed_rays(const Scene& scene, std::span<const AimedAt> aims, size_t count,
                                    uint64_t seed);

}  // namespace sightline
