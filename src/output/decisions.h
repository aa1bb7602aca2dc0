#pragma once
// What `--explain` and the statistics say of a picture, beside what find_needs finds.
#include "output/options.h"
#include "render/needs.h"

namespace sightline {

/// What lights the scene.
Decision light_decision(const LightOptions& light, const Scene& scene);

/// Whether OpenImageIO is loaded: only for pictures and textures that are not PNG, JPEG or EXR, and
/// for environment files.
void add_module_need(const RenderCommand& command, const Scene& scene, Needs& needs);

/// What coordinates are relative to, if it is not the world.
void add_frame_need(const Scene& scene, Needs& needs);

/// Which textures are not held in full.
void add_texture_need(const Scene& scene, Needs& needs);

}  // namespace sightline
