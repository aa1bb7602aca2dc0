#include "render/render_context.h"

namespace sightline {

RenderContext::RenderContext(const Scene& the_scene, const RenderSettings& the_settings,
                             const Needs& the_needs, const Intersector& the_intersector,
                             const Environment* the_environment, unsigned threads)
    : scene(the_scene),
      settings(the_settings),
      needs(the_needs),
      intersector(the_intersector),
      environment(the_environment),
      surfaces(scene, needs.mipmaps, threads),
      area_lights(scene, surfaces, threads),
      camera(settings, scene.bounds),
      single_sided(find_single_sided_faces(scene, settings, surfaces, camera, intersector)),
      roulette(scene, settings, environment != nullptr),
      translucent_bounds(sightline::translucent_bounds(scene)),
      world_unit(static_cast<float>(1 / scene.frame.scale)),
      absorption(absorption_coefficients(scene)),
      layers(scene, settings) {
    if (environment && settings.integrator == Integrator::appel)
        ambient = environment->mean_radiance();
}

Vec3 RenderContext::relative_iors(const MediumStack& media, const Surface& boundary) const {
    const auto iors_of = [&](uint32_t m) {
        return m == none ? Vec3(1) : channel_iors(scene.materials[m]);
    };
    return iors_of(beyond(boundary, media).current()) / iors_of(media.current());
}

float RenderContext::relative_ior(const MediumStack& media, const Surface& boundary) const {
    return relative_iors(media, boundary).y;
}

}  // namespace sightline
