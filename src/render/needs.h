#pragma once
// The features that a picture requires. They are derived from the scene and the settings; nothing
// else is built or traced.
#include "intersect/embree/embree.h"
#include "render/samples.h"
#include "render/settings.h"

namespace sightline {

/// One decision: the choice, the facts of scene and settings behind it, the work that it avoids.
struct Decision {
    std::string name, choice, because, saves;
};

struct Needs {
    bool pass_through = true;      ///< some coverage is below 1: camera rays may go on behind it
    bool coloured_shadows = true;  ///< translucent surfaces exist: shadow rays carry colour
    bool volumes = true;           ///< absorbing interiors exist
    bool area_lights = true;       ///< emissive triangles light the scene
    bool environment_light = true;
    bool secondary_rays = true;  ///< something reflects or refracts, and the integrator follows it
    bool noise = true;           ///< something is sampled: lights, a rough lobe, a lens
    bool mipmaps = true;
    bool first_hits = true;  ///< some layer shows the first hit of camera rays
    int depth = 8;           ///< of the recursion, as far as it can affect the picture
    bool tree = true;        ///< false: so few primitives that brute force is cheaper
    EmbreeOptions embree;
    std::vector<Decision> report;
};

/// The needs of the scene under the settings. `environment`: there is one.
Needs find_needs(const Scene& scene, const RenderSettings& settings, bool environment);

/// The engine (intersect/engines.h) that `auto` stands for: the cheapest one that serves the scene.
const char* engine_name(const Needs& needs);

/// Everything on, whatever the scene: find_needs must give the same picture bit for bit.
Needs all_needs(const RenderSettings& settings);

/// Names of the needs that were on although no ray of the render used them.
std::vector<std::string> unused_needs(const Needs& needs, const Counters& counters);

}  // namespace sightline
