#include "scene/gltf/cameras.h"

#include "scene/gltf/nodes.h"

#include <fmt/format.h>

#include <cmath>

namespace sightline {
namespace {

using nlohmann::json;

Camera read_camera(const Document& document, uint32_t index, const Mat4d& world) {
    const json& source = document.json["cameras"][index];
    const std::string place = fmt::format("cameras[{}]", index), type = source["type"];
    if (!source.contains(type)) document.fail(place + "." + type, "is missing");
    const json& lens = source[type];
    Camera camera;
    camera.name = source.value("name", "");
    camera.orthographic = type == "orthographic";
    if (camera.orthographic) {
        camera.xmag = std::abs(lens["xmag"].get<float>());
        camera.ymag = std::abs(lens["ymag"].get<float>());
        if (camera.xmag == 0 || camera.ymag == 0) document.fail(place, "xmag or ymag is zero");
    } else {
        camera.yfov = lens["yfov"];
        camera.aspect = lens.value("aspectRatio", 0.0f);
        if (!(camera.yfov > 0 && camera.yfov < pi)) document.fail(place, "yfov is not in (0, π)");
        if (camera.aspect < 0) document.fail(place, "aspectRatio is negative");
    }
    camera.znear = lens["znear"];
    camera.zfar = lens.value("zfar", camera.zfar);
    if (!(camera.znear >= 0 && camera.zfar > camera.znear)) {
        document.fail(place, fmt::format("nothing lies between znear {} and zfar {}", camera.znear,
                                         camera.zfar));
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

}  // namespace

std::vector<Camera> read_cameras(const Document& document, const std::vector<uint32_t>& nodes,
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

}  // namespace sightline
