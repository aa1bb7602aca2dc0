#include "render/layer_names.h"

#include "render/cryptomatte.h"

#include <algorithm>

namespace sightline {
namespace {

/// A dot would divide the name into layers.
std::string channel_name(const std::string& name) {
    std::string result = name.empty() ? "unnamed" : name;
    std::ranges::replace(result, '.', '_');
    return result;
}

std::vector<uint32_t> ids_of(const std::vector<std::string>& names) {
    std::vector<uint32_t> ids;
    for (const std::string& name : names) ids.push_back(cryptomatte_id(name));
    return ids;
}

}  // namespace

LayerNames make_layer_names(const Scene& scene, const RenderSettings& settings) {
    LayerNames names;
    if (settings.aovs.contains("cryptomatte")) {
        names.object_ids = ids_of(object_names(scene));
        names.material_ids = ids_of(material_names(scene));
    }
    if (!settings.aovs.contains("lights")) return names;
    std::vector<std::string>& groups = names.light_groups;
    const auto group_of = [&](const std::string& name) {
        const auto found = std::ranges::find(groups, name);
        const auto index = found - groups.begin();
        if (found == groups.end()) groups.push_back(name);
        return static_cast<uint16_t>(index);
    };
    for (const Light& light : scene.lights)
        names.group_of_light.push_back(group_of(channel_name(light.name)));
    names.environment = group_of("environment");
    names.emission = group_of("emission");
    return names;
}

}  // namespace sightline
