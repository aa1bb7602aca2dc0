#pragma once
// What a picture really needs: found once from the scene and the settings, then nothing else is
// built or traced.
#include "intersect/intersector.h"
#include "render/settings.h"

namespace sightline {

/// One decision: what was chosen, what in the scene or settings it follows from, what it avoids.
struct Decision {
    std::string name, choice, because, saves;
};

struct Needs {
    bool pass_through = true;      ///< coverage below 1 exists: eye rays may go on behind a surface
    bool coloured_shadows = true;  ///< translucent surfaces exist: shadow rays carry colour
    bool volumes = true;           ///< absorbing interiors exist
    bool area_lights = true;       ///< emissive triangles light the scene
    bool environment_light = true;
    bool secondary_rays = true;  ///< something reflects or refracts, and the integrator follows
    bool noise = true;           ///< something is sampled: light, a rough lobe, a lens
    bool mipmaps = true;
    bool first_hits = true;  ///< layers beyond beauty are asked for
    int depth = 8;           ///< of recursion that can still matter
    bool tree = true;        ///< false: so few primitives that trying each is cheaper
    EmbreeOptions embree;
    std::vector<Decision> report;
};

/// Decides from what the scene contains and the settings asks for. `environment`: the settings
/// brings one.
Needs find_needs(const Scene& scene, const RenderSettings& settings, bool environment);

/// The engine that the needs ask for. `scene` must outlive it. Throws Error.
std::unique_ptr<Intersector> make_intersector(const Scene& scene, const Needs& needs);

/// Everything on, whatever the scene: the model that `find_needs` must match bit by bit.
Needs all_needs(const RenderSettings& settings);

}  // namespace sightline
