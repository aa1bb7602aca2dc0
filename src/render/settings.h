#pragma once
#include "render/film.h"
#include "scene/scene.h"

#include <optional>
#include <set>

namespace sightline {

enum class Integrator {
    whitted,  ///< recursive (Whitted 1980), extended by sampled lobes, area lights, environments
    appel     ///< one eye ray, one shadow ray per light, local shading (Appel 1968)
};

/// What lies behind the scene for the eye.
enum class Background { environment, transparent, color };

/// Everything about a picture but the scene.
struct RenderSettings {
    int width = 512, height = 512;
    PixelRect crop;  ///< within the picture; empty: all of it
    Camera camera;
    float aperture = 0;  ///< diameter of the lens in world units
    float focus = 0;     ///< distance to the plane in focus, along the view; 0: the scene's centre
    Integrator integrator = Integrator::whitted;
    int depth = 8;           ///< most reflections and refractions along a path
    int samples = 64;        ///< per pixel
    float error = 0;         ///< > 0: sample each pixel until its relative error is below
    int max_samples = 1024;  ///< the bound of `error`
    uint32_t seed = 0;
    Background background = Background::environment;
    Vec3 background_color{0, 0, 0};
    float cutoff = 0.5f / 255;   ///< weights below are not traced: half a quantum of the output
    std::set<std::string> aovs;  ///< layers beyond beauty; see aov_names
    bool half = false;           ///< colours and normals in EXR as half floats
    unsigned threads = 0;        ///< 0: all
};

/// The layers that a settings may ask for.
inline constexpr const char* aov_names[] = {"depth", "position",    "normal",   "albedo",
                                            "uv",    "object",      "material", "samples",
                                            "cost",  "cryptomatte", "lights"};

/// How many of them, from the first, an EXR has where nobody says.
inline constexpr size_t default_aovs = 9;

/// The pixels to render.
inline PixelRect window_of(const RenderSettings& settings) {
    return settings.crop.width() > 0 ? settings.crop
                                     : PixelRect{0, 0, settings.width, settings.height};
}

}  // namespace sightline
