#include "scene/gltf/lights.h"

#include "scene/gltf/nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

using nlohmann::json;

// glTF requires 0 ≤ inner < outer ≤ π/2; equal angles are accepted and give a hard edge.
void read_cones(Document& document, const json& spot, const std::string& place, Light& light) {
    const float inner = spot.value("innerConeAngle", 0.0f);
    const float outer = spot.value("outerConeAngle", light.outer_cone_angle);
    light.outer_cone_angle = std::clamp(outer, 0.0f, pi / 2);
    light.inner_cone_angle = std::clamp(inner, 0.0f, light.outer_cone_angle);
    if (inner != light.inner_cone_angle || std::abs(outer - light.outer_cone_angle) > 1e-6f) {
        document.warn(place, fmt::format("cones of {} and {} are clamped to {} and {}", inner,
                                         outer, light.inner_cone_angle, light.outer_cone_angle));
    }
}

Light read_light(Document& document, size_t index, const Mat4d& world) {
    const json& source = document.json["extensions"]["KHR_lights_punctual"]["lights"][index];
    const std::string place = fmt::format("extensions.KHR_lights_punctual.lights[{}]", index);
    const std::string type = source["type"];
    Light light;
    light.kind = type == "directional" ? LightKind::directional
                 : type == "spot"      ? LightKind::spot
                                       : LightKind::point;
    light.name = source.value("name", "");
    if (source.contains("color")) {
        for (int i = 0; i < 3; ++i) light.color[i] = source["color"][i];
        if (std::min({light.color.x, light.color.y, light.color.z}) < 0) {
            document.warn(place + ".color", "has negative components, which are clamped to 0");
        }
        for (int i = 0; i < 3; ++i) light.color[i] = std::max(light.color[i], 0.0f);
    }
    light.intensity = source.value("intensity", 1.0f);
    if (light.intensity < 0) {
        document.warn(place + ".intensity", "is negative: the light is off");
        light.intensity = 0;
    }
    light.range = source.value("range", light.range);
    if (!(light.range > 0)) {
        document.warn(place + ".range", "is not positive: ignored");
        light.range = std::numeric_limits<float>::infinity();
    }
    if (light.kind == LightKind::spot && source.contains("spot")) {
        read_cones(document, source["spot"], place + ".spot", light);
    }
    light.position = {static_cast<float>(world[3][0]), static_cast<float>(world[3][1]),
                      static_cast<float>(world[3][2])};
    light.direction = Vec3(world_axis(world, {0, 0, -1}));
    return light;
}

}  // namespace

std::vector<Light> read_lights(Document& document, const std::vector<uint32_t>& nodes,
                               const std::vector<Mat4d>& world) {
    std::vector<Light> lights;
    for (const uint32_t i : nodes) {
        const json* use = find_extension(document.json["nodes"][i], "KHR_lights_punctual");
        if (!use) continue;
        Light& light = lights.emplace_back(read_light(document, (*use)["light"], world[i]));
        if (!document.nodes[i].name.empty()) light.name = document.nodes[i].name;
    }
    return lights;
}

}  // namespace sightline
