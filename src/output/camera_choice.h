#pragma once
#include "output/options.h"

namespace sightline {

/// The camera that the options choose in this scene. Throws Error if the file has no such camera.
Camera choose_camera(const ViewOptions& options, const Scene& scene);

}  // namespace sightline
