#pragma once
#include "render/aov.h"
#include "render/camera_rays.h"
#include "render/coincident_hits.h"
#include "render/ground.h"
#include "render/needs.h"
#include "render/roulette.h"
#include "render/single_sided.h"
#include "shade/environment.h"
#include "shade/lights.h"
#include "shade/media.h"
#include "shade/surface.h"

#include <memory>

namespace sightline {

/// What all pictures of a scene share that is derived from it. `scene` must outlive it.
struct SharedSurfaces {
    /// Prepares textures on `threads` threads (0: all).
    SharedSurfaces(const Scene& scene, bool mipmaps, unsigned threads);
    /// The same with textures that are prepared; those do not change when meshes move.
    SharedSurfaces(const Scene& scene, std::shared_ptr<const Surfaces> prepared, unsigned threads);

    std::shared_ptr<const Surfaces> surfaces;
    AreaLights area_lights;
    std::vector<Box3> translucent_bounds;
    std::vector<Vec3> absorption;  ///< by material: see absorption_coefficients
};

/// What stands behind and below a scene: pictures of it share this while their settings are alike.
/// `scene` must outlive it.
struct SharedBackdrop {
    /// `environment` may be null.
    SharedBackdrop(const Scene& scene, const RenderSettings& settings,
                   const Environment* environment);

    /// Whether a picture with these settings has this backdrop.
    bool serves(const RenderSettings& settings) const;

    Ground ground;
    std::unique_ptr<const Environment> blurred;  ///< as the camera sees it, or nullptr

    GroundSettings ground_settings;  ///< these three are what it was made of
    Integrator integrator;
    float background_blur;
};

/// Everything that tracing a tile reads; constant while tiles are traced. It refers to what the
/// constructor is given, which must outlive it, and owns what it derives from that.
struct RenderContext {
    /// Prepares textures on `threads` threads (0: all). `environment` may be null.
    RenderContext(const Scene& scene, const RenderSettings& settings, const Needs& needs,
                  const Intersector& intersector, const Environment* environment,
                  unsigned threads = 0);
    /// The same with what the scene's pictures share.
    RenderContext(const Scene& scene, const RenderSettings& settings, const Needs& needs,
                  const Intersector& intersector, const Environment* environment,
                  std::shared_ptr<const SharedSurfaces> surfaces,
                  std::shared_ptr<const SharedBackdrop> backdrop);
    RenderContext(const RenderContext&) = delete;
    RenderContext& operator=(const RenderContext&) = delete;

    /// Refractive indices of the medium beyond a boundary over those of `media`, on the side of its
    /// wo: for red, green and blue, which differ where the material disperses.
    Vec3 relative_iors(const MediumStack& media, const Surface& boundary) const;
    /// The one of green, the middle.
    float relative_ior(const MediumStack& media, const Surface& boundary) const;

    /// Whether a ray at this depth is the last of its path, traced to count sampled lights alone.
    bool is_last(int depth) const { return depth > needs.depth; }

    const Scene& scene;
    const RenderSettings& settings;
    const Needs& needs;
    const Intersector& intersector;
    std::shared_ptr<const SharedBackdrop> backdrop;
    const Ground& ground;
    const Environment* environment;  ///< or nullptr; below the ground, what that sends

    std::shared_ptr<const SharedSurfaces> shared;
    const Surfaces& surfaces;
    const AreaLights& area_lights;
    CameraRays camera;
    LoneSurfaces lone_surfaces;
    SingleSidedFaces single_sided;
    Roulette roulette;
    const std::vector<Box3>& translucent_bounds;
    float world_unit;  ///< the length of a unit of the scene's frame
    const std::vector<Vec3>& absorption;
    Vec3 ambient{0, 0, 0};  ///< Appel's ambient light: the environment's mean radiance
    Layers layers;          ///< beauty and those that the settings request
};

}  // namespace sightline
