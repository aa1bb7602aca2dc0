#include "render/needs.h"

#include "intersect/few_shapes.h"
#include "render/embree_choice.h"
#include "shade/bsdf.h"
#include "shade/media.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace sightline {
namespace {

/// What is visible: the materials that some placed geometry uses.
std::vector<const Material*> used_materials(const Scene& scene) {
    std::vector<bool> used(scene.materials.size());
    for (const Instance& instance : scene.instances) {
        const Group& group = scene.groups[instance.group];
        for (const uint32_t m : group.meshes) used[scene.meshes[m].material] = true;
        for (const uint32_t s : group.shapes) used[scene.shapes[s].material] = true;
    }
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

/// Whether they have been decoded or not.
size_t count_images(const Scene& scene, const std::vector<const Material*>& materials) {
    std::set<uint32_t> images;
    for (const Material* material : materials)
        for_each_texture(*material, [&](const TextureRef& ref) {
            images.insert(scene.textures[ref.texture].image);
        });
    return images.size();
}

bool emits(const Material& m) { return max_component(m.emissive_factor) > 0 && !m.unlit; }

/// A texture may make parts of the surface smooth, but not all of it.
bool has_rough_lobe(const Material& m) {
    return m.roughness_factor >= smooth_roughness || m.anisotropy_strength > 0 ||
           (m.clearcoat_factor > 0 && m.clearcoat_roughness_factor >= smooth_roughness);
}

/// Reflections after which the weight must be below the cutoff: r^depth < cutoff.
int useful_depth(float reflectance, const RenderSettings& settings) {
    if (settings.integrator == Integrator::appel || reflectance < settings.cutoff) return 0;
    if (reflectance >= 1) return settings.depth;
    const float bound = std::log(settings.cutoff) / std::log(reflectance);
    return std::min(settings.depth, static_cast<int>(std::floor(bound)));
}

}  // namespace

Needs find_needs(const Scene& scene, const RenderSettings& settings, bool environment) {
    const auto materials = used_materials(scene);
    Needs needs;
    const auto decide = [&](const char* name, bool& need, size_t users, const char* because,
                            const char* saves) {
        need = users > 0;
        needs.report.push_back(
            {name, need ? "on" : "off", fmt::format("{} {}", users, because), need ? "" : saves});
    };
    decide("pass_through", needs.pass_through,
           count(materials,
                 [](const Material& m) {
                     return m.alpha_mode != AlphaMode::opaque || !m.double_sided;
                 }),
           "materials with alpha MASK or BLEND, or with culled back faces",
           "a coverage test at every hit");
    decide("coloured_shadows", needs.coloured_shadows, count(materials, is_translucent),
           "materials that let light through",
           "shading along shadow rays: they only ask whether anything is in the way");
    decide("volumes", needs.volumes, count(materials, absorbs),
           "materials with an absorbing interior", "an exponential per ray segment");
    decide("area_lights", needs.area_lights, count(materials, emits), "emissive materials",
           "a sampled light and a shadow ray per hit");
    decide("environment_light", needs.environment_light,
           environment && settings.integrator == Integrator::whitted ? 1 : 0, "environment",
           "importance tables, and a sampled direction and shadow ray per hit");
    float reflectance = 0;
    for (const Material* m : materials) reflectance = std::max(reflectance, max_reflectance(*m));
    needs.depth = useful_depth(reflectance, settings);
    needs.secondary_rays = needs.depth > 0;
    needs.report.push_back(
        {"depth", fmt::format("{}", needs.depth),
         fmt::format("largest reflectance {:.3f}, cutoff {:.4f}, asked for {}", reflectance,
                     settings.cutoff, settings.depth),
         needs.depth < settings.depth ? "waves whose weight cannot matter" : ""});
    const size_t rough =
        needs.secondary_rays
            ? count(materials,
                    [&](const Material& m) {
                        return has_rough_lobe(m) && max_reflectance(m) >= settings.cutoff;
                    })
            : 0;
    decide("noise", needs.noise,
           rough + needs.environment_light + needs.area_lights + (settings.aperture > 0),
           "things that are sampled: rough lobes, environment, area lights, lens",
           "samples of a sampler by error: one a pixel will do where neighbours agree");
    decide("mipmaps", needs.mipmaps, count_images(scene, materials), "images on materials",
           "texture pyramids");
    const size_t others = settings.aovs.count("lights") + settings.aovs.count("cryptomatte");
    decide("first_hits", needs.first_hits, settings.aovs.size() - others,
           "layers of what is seen first", "keeping what each sample saw first");
    const bool few = make_few_shapes(scene) != nullptr;
    decide("tree", needs.tree, few ? 0 : 1,
           few ? "of its spheres, planes and triangles are too many to try each"
               : "scene of more than a handful of primitives",
           "building and walking a tree, and Embree altogether");
    if (needs.tree) choose_embree(scene, settings, needs);
    needs.embree.threads = settings.threads;
    return needs;
}

/// The cheapest engine that answers for this scene.
std::unique_ptr<Intersector> make_intersector(const Scene& scene, const Needs& needs) {
    if (!needs.tree)
        if (auto few = make_few_shapes(scene)) return few;
    return make_embree(scene, needs.embree);
}

Needs all_needs(const RenderSettings& settings) {
    Needs needs;
    needs.depth = settings.integrator == Integrator::appel ? 0 : settings.depth;
    needs.secondary_rays = needs.depth > 0;
    needs.embree.threads = settings.threads;
    return needs;
}

}  // namespace sightline
