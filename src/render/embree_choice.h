#pragma once
#include "render/needs.h"

namespace sightline {

/// Sets Embree's mode and build quality for the scene and reports why. The mode is ROBUST unless
/// src/render/breakdown.json shows that the default mode errs nowhere near what this scene asks:
/// only baked triangles, none sharing an edge, and every knob below that of a measured failure.
/// The quality is choose_build_quality's in the default mode; ROBUST trees do not split.
void choose_embree(const Scene& scene, const RenderSettings& settings, Needs& needs);

}  // namespace sightline
