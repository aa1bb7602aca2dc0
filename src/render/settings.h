#pragma once
#include "render/film.h"
#include "scene/scene.h"

#include <optional>
#include <set>

namespace sightline {

enum class Integrator {
    whitted,  ///< recursive (Whitted 1980), extended by sampled lobes, area lights, environments
    appel     ///< one camera ray, one shadow ray per light, local shading (Appel 1968)
};

/// The background of the picture.
enum class Background { environment, transparent, color };

/// Whether single-sided faces hold off light that arrives at their backs, which are not drawn.
enum class SingleSidedShadows {
    automatic,  ///< by material and view: see find_single_sided_faces
    on,
    off
};

/// What stands below the scene: nothing; a plane that shows shadows and reflections alone; a matte
/// one that becomes the background's colour at a distance; a matte one.
enum class GroundKind { nothing, shadow, cyclorama, matte };

/// A horizontal plane without end below the scene (render/ground.h).
struct GroundSettings {
    GroundKind kind = GroundKind::nothing;
    float height = 0;     ///< its y
    Vec3 color{0, 0, 0};  ///< albedo of a matte one, linear Rec. 709
    float mirror = 0;     ///< of a shadow ground: reflectance seen from above
};

/// Everything about a picture except the scene. The key of kept tiles covers all fields
/// (output/tile_key.h).
struct RenderSettings {
    int width = 512, height = 512;
    PixelRect crop;  ///< the part to render; empty: all
    Camera camera;
    float aperture = 0;  ///< diameter of the lens in world units
    float focus = 0;  ///< to the plane in focus, along the view, world units; 0: the scene's centre
    Integrator integrator = Integrator::whitted;
    SingleSidedShadows single_sided_shadows = SingleSidedShadows::automatic;
    int depth = 12;    ///< maximum reflections and refractions along a path
    int samples = 64;  ///< per pixel
    float error = 0;   ///< > 0: sample each pixel as needs_samples says for this relative error
    int max_samples = 1024;  ///< per pixel, with `error`
    uint32_t seed = 0;
    Background background = Background::environment;
    Vec3 background_color{0, 0, 0};  ///< linear Rec. 709
    /// Of the environment as the camera sees it, not of its light: the radius in degrees of a spot
    /// that a point becomes (twice the standard deviation).
    float background_blur = 0;
    GroundSettings ground;
    bool full_textures = false;  ///< decode levels that no ray can read, too (texture_levels.h)
    float cutoff = 0.5f / 255;   ///< radiance that may be left out: half a quantum of the output
    std::set<std::string> aovs;  ///< layers in addition to beauty, of aov_names
    bool half = false;           ///< colours and normals in EXR as half floats
};

/// The names of layers.
inline constexpr const char* aov_names[] = {"depth", "position",    "normal",   "albedo",
                                            "uv",    "object",      "material", "samples",
                                            "cost",  "cryptomatte", "lights"};

/// An EXR has the first of them by default.
inline constexpr size_t default_aovs = 9;

/// The pixels to render.
inline PixelRect window_of(const RenderSettings& settings) {
    return settings.crop.width() > 0 ? settings.crop
                                     : PixelRect{0, 0, settings.width, settings.height};
}

}  // namespace sightline
