#include "scene/scene.h"

namespace sightline {
namespace {

// All except the occlusion texture.
void visit_textures(auto& m, const auto& visit) {
    for (auto* ref : {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture,
                      &m.emissive_texture, &m.transmission_texture, &m.specular_texture,
                      &m.specular_color_texture, &m.glossiness_texture, &m.clearcoat_texture,
                      &m.clearcoat_roughness_texture, &m.clearcoat_normal_texture,
                      &m.sheen_color_texture, &m.sheen_roughness_texture, &m.anisotropy_texture,
                      &m.iridescence_texture, &m.iridescence_thickness_texture,
                      &m.diffuse_transmission_texture, &m.diffuse_transmission_color_texture})
        if (*ref) visit(*ref);
}

}  // namespace

void for_each_texture(const Material& material,
                      const std::function<void(const TextureRef&)>& visit) {
    visit_textures(material, visit);
}

void for_each_texture(Material& material, const std::function<void(TextureRef&)>& visit) {
    visit_textures(material, visit);
}

std::vector<bool> used_materials(const Scene& scene) {
    std::vector<bool> used(scene.materials.size());
    for (const Instance& instance : scene.instances) {
        const Group& group = scene.groups[instance.group];
        for (const uint32_t m : group.meshes) used[scene.meshes[m].material] = true;
        for (const uint32_t s : group.shapes) used[scene.shapes[s].material] = true;
    }
    return used;
}

}  // namespace sightline
