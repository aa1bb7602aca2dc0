#pragma once
// Where a document's scene lies, before anything of it becomes float. Internal to src/scene.
#include "scene/gltf/document.h"

#include <map>

namespace sightline {

/// The frame of a scene, from its rest pose: the same for all times of its animations.
struct Placement {
    Frame frame;
    double radius = 0;                         ///< half the diagonal of the scene, in the frame
    std::map<uint32_t, Box3> position_bounds;  ///< by accessor of POSITION: of all finite vertices
};

/// The placement of the scene that `options` selects. To be called before the document is posed.
/// Throws Error.
Placement place_scene(Document& document, const LoadOptions& options);

/// The frame for an object's vertices: the scale that they need, and, if rays are taken to object
/// space (`instanced`) by the inverse of `matrix`, an origin where that loses what the scene's
/// frame gains.
Frame object_frame(const Box3& bounds, const Mat4d& matrix, bool instanced,
                   const Placement& placement);

}  // namespace sightline
