#include "scene/gltf/cameras_lights.h"

#include "scene/gltf/nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

using nlohmann::json;

// Reads a camera's lens. Throws FaultyPart if nothing can be seen through it.
void read_lens(const Document& document, const json& source, const std::string& place,
               Camera& camera) {
    const auto reject = [&](const std::string& at, const std::string& reason) {
        document.fail_part(Fault::camera, at, reason);
    };
    const std::string type = source["type"];
    if (!source.contains(type)) reject(place + "." + type, "is missing");
    const json& lens = source[type];
    camera.orthographic = type == "orthographic";
    if (camera.orthographic) {
        camera.xmag = std::abs(lens["xmag"].get<float>());
        camera.ymag = std::abs(lens["ymag"].get<float>());
        if (camera.xmag == 0 || camera.ymag == 0) reject(place, "xmag or ymag is zero");
    } else {
        camera.yfov = lens["yfov"];
        camera.aspect = lens.value("aspectRatio", 0.0f);
        if (!(camera.yfov > 0 && camera.yfov < pi)) reject(place, "yfov is not in (0, π)");
        if (camera.aspect < 0) reject(place, "aspectRatio is negative");
    }
    camera.znear = lens["znear"];
    camera.zfar = lens.value("zfar", camera.zfar);
    if (!(camera.znear >= 0 && camera.zfar > camera.znear))
        reject(place,
               fmt::format("nothing lies between znear {} and zfar {}", camera.znear, camera.zfar));
}

Camera read_camera(Document& document, uint32_t index, const Mat4d& world) {
    const json& source = document.json["cameras"][index];
    Camera camera;
    camera.name = source.value("name", "");
    try {
        read_lens(document, source, fmt::format("cameras[{}]", index), camera);
    } catch (const FaultyPart& part) {
        document.report(part);
        camera = {};
        camera.name = source.value("name", "");
        camera.fault = part.place + ": " + part.detail;
    }
    // Rigid: keep the view direction and make up orthogonal to it.
    const Vec3d z = world_axis(world, {0, 0, 1});
    Vec3d x = cross(world_axis(world, {0, 1, 0}), z);
    if (dot(x, x) < 1e-12) x = cross(std::abs(z.y) < 0.9 ? Vec3d(0, 1, 0) : Vec3d(1, 0, 0), z);
    x /= std::sqrt(dot(x, x));
    const Vec3d rows[3] = {x, cross(z, x), z};
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) camera.to_world[r][c] = static_cast<float>(rows[r][c]);
        camera.to_world[3][r] = static_cast<float>(world[3][r]);
    }
    return camera;
}

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
        if (std::min({light.color.x, light.color.y, light.color.z}) < 0)
            document.warn(place + ".color", "has negative components, which are clamped to 0");
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
    if (light.kind == LightKind::spot && source.contains("spot"))
        read_cones(document, source["spot"], place + ".spot", light);
    light.position = {static_cast<float>(world[3][0]), static_cast<float>(world[3][1]),
                      static_cast<float>(world[3][2])};
    light.direction = Vec3(world_axis(world, {0, 0, -1}));
    return light;
}

}  // namespace

std::vector<Camera> read_cameras(Document& document, const std::vector<uint32_t>& nodes,
                                 const std::vector<Mat4d>& world) {
    std::vector<Camera> cameras;
    for (const uint32_t i : nodes) {
        const GltfNode& node = document.nodes[i];
        if (node.camera == none) continue;
        Camera& camera = cameras.emplace_back(read_camera(document, node.camera, world[i]));
        if (!node.name.empty()) camera.name = node.name;
    }
    return cameras;
}

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
