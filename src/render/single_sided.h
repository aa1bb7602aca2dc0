#pragma once
// Faces that are seen from behind: single-sided ones that light passes.
#include "intersect/intersector.h"
#include "render/camera_rays.h"
#include "render/lone_surfaces.h"
#include "render/needs.h"
#include "shade/surface.h"

namespace sightline {

/// The single-sided materials whose faces let light through that arrives at their undrawn backs.
/// Light that arrives at a front is held off all the same, so that a closed mesh whose faces look
/// outwards casts the same shadow either way.
struct SingleSidedFaces {
    std::vector<uint8_t> pass_light;  ///< by material; empty: none does
    Decision decision;                ///< for --explain

    bool any_pass() const { return !pass_light.empty(); }
    bool passes(uint32_t material) const { return any_pass() && pass_light[material]; }
};

/// Decides by settings.single_sided_shadows. `automatic` chooses the unlit materials (sky domes,
/// outlines), and those with a back that this view looks through: some ray of a fixed grid over the
/// whole frame meets it before the first surface that is drawn. The choice depends on scene,
/// camera, size and engine alone: not on crop, tiles, samples or seed.
SingleSidedFaces find_single_sided_faces(const Scene& scene, const RenderSettings& settings,
                                         const Surfaces& surfaces, const CameraRays& camera,
                                         const Intersector& intersector, const LoneSurfaces& lone);

}  // namespace sightline
