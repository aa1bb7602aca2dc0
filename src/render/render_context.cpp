#include "render/render_context.h"

#include <tuple>
#include <utility>

namespace sightline {

SharedSurfaces::SharedSurfaces(const Scene& scene, bool mipmaps, unsigned threads)
    : SharedSurfaces(scene, std::make_shared<Surfaces>(scene, mipmaps, threads), threads) {}

SharedSurfaces::SharedSurfaces(const Scene& scene, std::shared_ptr<const Surfaces> prepared,
                               unsigned threads)
    : surfaces(std::move(prepared)),
      area_lights(scene, *surfaces, threads),
      translucent_bounds(sightline::translucent_bounds(scene)),
      absorption(absorption_coefficients(scene)) {}

SharedBackdrop::SharedBackdrop(const Scene& scene, const RenderSettings& settings,
                               const Environment* environment)
    : ground(scene, settings, environment),
      ground_settings(settings.ground),
      integrator(settings.integrator),
      background_blur(settings.background_blur) {
    if (environment && background_blur > 0)
        blurred = std::make_unique<Environment>(environment->blurred(background_blur * pi / 180));
}

bool SharedBackdrop::serves(const RenderSettings& settings) const {
    const auto values = [](const GroundSettings& of) {
        const auto& [kind, height, color, mirror] = of;
        return std::tuple(kind, height, color, mirror);
    };
    return values(settings.ground) == values(ground_settings) &&
           settings.integrator == integrator && settings.background_blur == background_blur;
}

RenderContext::RenderContext(const Scene& the_scene, const RenderSettings& the_settings,
                             const Needs& the_needs, const Intersector& the_intersector,
                             const Environment* the_environment, unsigned threads)
    : RenderContext(the_scene, the_settings, the_needs, the_intersector, the_environment,
                    std::make_shared<SharedSurfaces>(the_scene, the_needs.mipmaps, threads),
                    std::make_shared<SharedBackdrop>(the_scene, the_settings, the_environment)) {}

RenderContext::RenderContext(const Scene& the_scene, const RenderSettings& the_settings,
                             const Needs& the_needs, const Intersector& the_intersector,
                             const Environment* the_environment,
                             std::shared_ptr<const SharedSurfaces> the_surfaces,
                             std::shared_ptr<const SharedBackdrop> the_backdrop)
    : scene(the_scene),
      settings(the_settings),
      needs(the_needs),
      intersector(the_intersector),
      backdrop(std::move(the_backdrop)),
      ground(backdrop->ground),
      environment(ground.environment() ? ground.environment() : the_environment),
      shared(std::move(the_surfaces)),
      surfaces(*shared->surfaces),
      area_lights(shared->area_lights),
      camera(settings, scene.bounds),
      lone_surfaces(scene, intersector),
      single_sided(
          find_single_sided_faces(scene, settings, surfaces, camera, intersector, lone_surfaces)),
      roulette(scene, settings, environment != nullptr),
      translucent_bounds(shared->translucent_bounds),
      world_unit(static_cast<float>(1 / scene.frame.scale)),
      absorption(shared->absorption),
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
