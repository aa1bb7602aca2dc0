#pragma once
#include "output/options.h"

namespace sightline {

/// A camera, and why the picture has it.
struct CameraChoice {
    Camera camera;
    std::string name, because;
};

/// The camera that the command chooses in this scene, its asset's. Throws Error if the file has no
/// such camera.
CameraChoice choose_camera(const RenderCommand& command, const Scene& scene);

}  // namespace sightline
