#include "render/needs.h"

#include "intersect/embree/robust_choice.h"
#include "intersect/few_shapes.h"
#include "render/aov.h"
#include "render/emission.h"
#include "render/roulette.h"
#include "shade/bsdf.h"
#include "shade/media.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>

namespace sightline {
namespace {

/// The materials that some instance uses.
std::vector<const Material*> list_materials(const Scene& scene) {
    const std::vector<bool> used = used_materials(scene);
    std::vector<const Material*> result;
    for (size_t i = 0; i < used.size(); ++i)
        if (used[i]) result.push_back(&scene.materials[i]);
    return result;
}

template <class Predicate>
size_t count(const std::vector<const Material*>& materials, Predicate predicate) {
    return static_cast<size_t>(std::count_if(materials.begin(), materials.end(),
                                             [&](const Material* m) { return predicate(*m); }));
}

/// Counts images whether they have been decoded or not.
size_t count_images(const Scene& scene, const std::vector<const Material*>& materials) {
    std::set<uint32_t> images;
    for (const Material* material : materials)
        for_each_texture(*material, [&](const TextureRef& ref) {
            images.insert(scene.textures[ref.texture].image);
        });
    return images.size();
}

/// A texture of roughness may make parts of the surface smooth, but not all of it; one of
/// glossiness may make parts rough.
bool has_rough_lobe(const Material& m) {
    return m.roughness_factor >= smooth_roughness || m.glossiness_texture ||
           m.anisotropy_strength > 0 || m.diffuse_transmission_factor > 0 ||
           (m.clearcoat_factor > 0 && m.clearcoat_roughness_factor >= smooth_roughness);
}

/// True if a ray of this weight can bring as much as the cutoff.
bool is_useful(float weight, float brightest, const RenderSettings& settings) {
    return weight > 0 && weight * brightest >= settings.cutoff;
}

/// The largest depth d at which rays can bring the cutoff: reflectance^d · brightest ≥ cutoff.
int useful_depth(float reflectance, float brightest, const RenderSettings& settings) {
    if (settings.integrator == Integrator::appel || !is_useful(reflectance, brightest, settings))
        return 0;
    if (reflectance >= 1 || std::isinf(brightest)) return settings.depth;
    const float bound = std::log(settings.cutoff / brightest) / std::log(reflectance);
    return std::min(settings.depth, static_cast<int>(std::floor(bound)));
}

bool may_be_uncovered(const Material& m) {
    return m.alpha_mode != AlphaMode::opaque || !m.double_sided;
}

/// Sets Embree's mode and build quality and reports the reasons.
void choose_embree(const Scene& scene, const RenderSettings& settings, Needs& needs) {
    const RobustChoice choice = choose_robust(scene, settings.camera.to_world.translation());
    needs.embree.robust = choice.robust;
    needs.embree.quality = choice.quality;
    needs.report.push_back({"embree_mode", choice.robust ? "robust" : "default", choice.reason,
                            choice.robust ? "" : "the wider bounds of ROBUST's tests"});
    if (choice.robust) return;
    const bool splits = choice.quality == BuildQuality::high;
    needs.report.push_back({"spatial_splits", splits ? "on" : "off",
                            fmt::format("a line enters {:.1f} triangles' boxes, {:.1f} times as "
                                        "large as flat ones",
                                        choice.overlap.boxes_entered, choice.overlap.area_ratio),
                            splits ? "" : "ten times the build time"});
}

void decide(Needs& needs, bool Needs::*need, const char* name, size_t users, const char* because,
            const char* saves) {
    const bool on = users > 0;
    needs.*need = on;
    needs.report.push_back(
        {name, on ? "on" : "off", fmt::format("{} {}", users, because), on ? "" : saves});
}

void decide_depth(Needs& needs, const std::vector<const Material*>& materials, float brightest,
                  const RenderSettings& settings) {
    float reflectance = 0;
    for (const Material* m : materials) reflectance = std::max(reflectance, max_reflectance(*m));
    needs.depth = useful_depth(reflectance, brightest, settings);
    needs.secondary_rays = needs.depth > 0;
    needs.report.push_back(
        {"depth", fmt::format("{}", needs.depth),
         fmt::format("largest reflectance {:.3f}, brightest radiance {:.1f}, cutoff {:.4f}, "
                     "maximum {}",
                     reflectance, brightest, settings.cutoff, settings.depth),
         needs.depth < settings.depth ? "waves that bring less than the cutoff" : ""});
}

size_t count_sampled(const Needs& needs, const std::vector<const Material*>& materials,
                     float brightest, const RenderSettings& settings) {
    const auto is_sampled = [&](const Material& m) {
        return has_rough_lobe(m) && is_useful(max_reflectance(m), brightest, settings);
    };
    const size_t rough = needs.secondary_rays ? count(materials, is_sampled) : 0;
    const bool roulette = needs.secondary_rays && brightest > 1;
    return rough + roulette + needs.environment_light + needs.area_lights + (settings.aperture > 0);
}

}  // namespace

Needs find_needs(const Scene& scene, const RenderSettings& settings, bool environment) {
    const auto materials = list_materials(scene);
    Needs needs;
    decide(needs, &Needs::pass_through, "pass_through", count(materials, may_be_uncovered),
           "materials with alpha MASK or BLEND, or with culled back faces",
           "a coverage test at every hit");
    decide(needs, &Needs::coloured_shadows, "coloured_shadows", count(materials, is_translucent),
           "materials that transmit light",
           "shading along shadow rays: an any-hit query is enough");
    decide(needs, &Needs::volumes, "volumes", count(materials, absorbs),
           "materials with an absorbing interior", "an exponential per ray segment");
    decide(needs, &Needs::area_lights, "area_lights", count(materials, emits), "emissive materials",
           "a light sample and a shadow ray per hit");
    decide(needs, &Needs::environment_light, "environment_light",
           environment && settings.integrator == Integrator::whitted ? 1 : 0, "environment",
           "importance tables, and a sampled direction and shadow ray per hit");
    const float brightest = brightest_radiance(scene, settings, environment);
    decide_depth(needs, materials, brightest, settings);
    decide(needs, &Needs::noise, "noise", count_sampled(needs, materials, brightest, settings),
           "sampled things: rough lobes, faint paths, environment, area lights, lens",
           "samples of a render with a target error: one per pixel where neighbours agree");
    decide(needs, &Needs::mipmaps, "mipmaps", count_images(scene, materials), "images on materials",
           "texture pyramids");
    const size_t other_layers = settings.aovs.count("lights") + settings.aovs.count("cryptomatte") +
                                settings.aovs.count(shown_layer) +
                                settings.aovs.count(through_layer);
    decide(needs, &Needs::first_hits, "first_hits", settings.aovs.size() - other_layers,
           "layers of the first hit", "storing the first hit of each sample");
    const bool few = has_few_shapes(scene);
    decide(needs, &Needs::tree, "tree", few ? 0 : 1,
           few ? "scenes too large for brute force" : "scene too large for brute force",
           "building and traversing a tree, and Embree altogether");
    if (needs.tree) choose_embree(scene, settings, needs);
    return needs;
}

const char* engine_name(const Needs& needs) {
    if (!needs.tree) return "few-shapes";
    return needs.embree.robust ? "embree" : "embree-default";
}

Needs all_needs(const RenderSettings& settings) {
    Needs needs;
    needs.depth = settings.integrator == Integrator::appel ? 0 : settings.depth;
    needs.secondary_rays = needs.depth > 0;
    return needs;
}

std::vector<std::string> unused_needs(const Needs& needs, const Counters& c) {
    const uint64_t secondary = c.rays[static_cast<size_t>(RayKind::reflection)] +
                               c.rays[static_cast<size_t>(RayKind::refraction)];
    const std::tuple<const char*, bool, uint64_t> uses[] = {
        {"pass_through", needs.pass_through, c.uncovered_hits},
        {"coloured_shadows", needs.coloured_shadows, c.coloured_shadow_rays},
        {"volumes", needs.volumes, c.absorbed_rays},
        {"area_lights", needs.area_lights, c.area_light_samples},
        {"environment_light", needs.environment_light, c.environment_samples},
        {"secondary_rays", needs.secondary_rays, secondary},
    };
    std::vector<std::string> unused;
    for (const auto& [name, on, count] : uses)
        if (on && count == 0) unused.push_back(name);
    return unused;
}

}  // namespace sightline
