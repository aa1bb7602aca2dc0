#include "scene/gltf/nodes.h"

#include "core/text.h"
#include "scene/gltf/accessor.h"
#include "scene/gltf/contents.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

using nlohmann::json;

// p' = p * M scales first, then rotates, then translates.
Mat4d compose(const Vec3d& translation, const std::array<double, 4>& rotation, const Vec3d& scale) {
    auto [x, y, z, w] = rotation;
    const double length = std::sqrt(x * x + y * y + z * z + w * w);
    if (length > 0 && std::isfinite(length)) {
        x /= length, y /= length, z /= length, w /= length;
    } else {
        x = y = z = 0, w = 1;
    }
    const Vec3d rows[3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
                           {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
                           {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}};
    Mat4d m;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) m[r][c] = scale[r] * rows[r][c];
        m[3][r] = translation[r];
    }
    return m;
}

// The scene that `options` chooses; nullptr where the file has none.
const json* chosen_scene(Document& document, const LoadOptions& options) {
    const json& scenes = document.list("scenes");
    if (!options.scene.empty()) {
        const std::vector<std::string> names = names_in(document, "scenes");
        if (const auto found = find_choice(names, options.scene)) return &scenes[*found];
        document.fail("scenes", fmt::format("there is no scene \"{}\"; the file has {}",
                                            options.scene, list_choices(names)));
    }
    return scenes.empty() ? nullptr : &scenes[document.json.value("scene", size_t{0})];
}

std::vector<uint32_t> scene_roots(Document& document, const LoadOptions& options) {
    std::vector<uint32_t> roots;
    if (const json* scene = chosen_scene(document, options)) {
        scene->value("nodes", json::array()).get_to(roots);
    } else {
        for (uint32_t i = 0; i < document.nodes.size(); ++i) {
            if (document.nodes[i].parent == none) roots.push_back(i);
        }
    }
    return roots;
}

bool is_hidden(const json& node) {
    const json* visibility = find_extension(node, "KHR_node_visibility");
    return visibility && !visibility->value("visible", true);
}

// A direction of the node's space in the world, unit; `fallback` where scale 0 has swallowed it.
Vec3d world_axis(const Mat4d& m, const Vec3d& axis, const Vec3d& fallback) {
    Vec3d d;
    m.multDirMatrix(axis, d);
    const double length = std::sqrt(dot(d, d));
    return length > 0 && std::isfinite(length) ? d / length : fallback;
}

Vec3 to_float(const Vec3d& v) { return Vec3(v); }

Camera read_camera(Document& document, uint32_t index, const Mat4d& world) {
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
    // Rigid: the view direction stays, then up is made orthogonal to it.
    const Vec3d z = world_axis(world, {0, 0, 1}, {0, 0, 1});
    Vec3d x = cross(world_axis(world, {0, 1, 0}, {0, 1, 0}), z);
    if (dot(x, x) < 1e-12) x = cross(std::abs(z.y) < 0.9 ? Vec3d(0, 1, 0) : Vec3d(1, 0, 0), z);
    x /= std::sqrt(dot(x, x));
    const Vec3d rows[3] = {x, cross(z, x), z};
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) camera.to_world[r][c] = static_cast<float>(rows[r][c]);
        camera.to_world[3][r] = static_cast<float>(world[3][r]);
    }
    return camera;
}

// glTF wants 0 ≤ inner < outer ≤ π/2; where both are one, the edge is hard.
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
            document.warn(place + ".color", "is negative in part, which is taken for 0");
        }
        for (int i = 0; i < 3; ++i) light.color[i] = std::max(light.color[i], 0.0f);
    }
    light.intensity = source.value("intensity", 1.0f);
    if (light.intensity < 0) {
        document.warn(place + ".intensity", "is negative: the light is out");
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
    light.direction = to_float(world_axis(world, {0, 0, -1}, {0, 0, -1}));
    return light;
}

bool is_finite(const Mat4d& m) {
    for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) {
            if (!std::isfinite(static_cast<float>(m[r][c]))) return false;
        }
    }
    return true;
}

}  // namespace

Mat4d local_matrix(const GltfNode& node) {
    if (!node.has_matrix) return compose(node.translation, node.rotation, node.scale);
    Mat4d m = node.matrix;
    for (int r = 0; r < 3; ++r) m[r][3] = 0;  // affine, whatever the file says
    m[3][3] = 1;
    return m;
}

std::vector<Mat4d> world_matrices(const Document& document) {
    const std::vector<GltfNode>& nodes = document.nodes;
    std::vector<Mat4d> world(nodes.size());
    std::vector<uint32_t> open;
    for (uint32_t i = 0; i < nodes.size(); ++i) {
        if (nodes[i].parent == none) open.push_back(i);
    }
    while (!open.empty()) {
        const uint32_t i = open.back();
        open.pop_back();
        const uint32_t parent = nodes[i].parent;
        world[i] = local_matrix(nodes[i]);
        if (parent != none) world[i] = world[i] * world[parent];
        if (!is_finite(world[i])) {
            document.fail(fmt::format("nodes[{}]", i), "its matrix to world space is not finite");
        }
        open.insert(open.end(), nodes[i].children.begin(), nodes[i].children.end());
    }
    return world;
}

std::vector<uint32_t> visible_nodes(Document& document, const LoadOptions& options) {
    std::vector<uint32_t> open = scene_roots(document, options), visible;
    std::ranges::reverse(open);
    std::vector<bool> seen(document.nodes.size(), false);
    while (!open.empty()) {
        const uint32_t i = open.back();
        open.pop_back();
        if (seen[i]) {
            document.warn(fmt::format("nodes[{}]", i), "is in the scene twice: drawn once");
            continue;
        }
        seen[i] = true;
        if (is_hidden(document.json["nodes"][i])) continue;
        visible.push_back(i);
        const std::vector<uint32_t>& children = document.nodes[i].children;
        open.insert(open.end(), children.rbegin(), children.rend());
    }
    return visible;
}

void place_cameras_and_lights(Document& document, const std::vector<uint32_t>& nodes,
                              const std::vector<Mat4d>& world, Scene& scene) {
    for (const uint32_t i : nodes) {
        const GltfNode& node = document.nodes[i];
        if (node.camera != none) {
            Camera& camera =
                scene.cameras.emplace_back(read_camera(document, node.camera, world[i]));
            if (!node.name.empty()) camera.name = node.name;
        }
        const json* light = find_extension(document.json["nodes"][i], "KHR_lights_punctual");
        if (light) {
            Light& placed =
                scene.lights.emplace_back(read_light(document, (*light)["light"], world[i]));
            if (!node.name.empty()) placed.name = node.name;
        }
    }
}

std::optional<Vec3> scene_background(Document& document, const LoadOptions& options) {
    const json* scene = chosen_scene(document, options);
    const json* background = scene ? find_extension(*scene, "SIGHTLINE_background") : nullptr;
    if (!background) return {};
    const std::array<float, 3> color = (*background)["color"];
    return Vec3(color[0], color[1], color[2]);
}

std::vector<Mat4d> placements(const Document& document, uint32_t node, const Mat4d& world) {
    const json* extension = find_extension(document.json["nodes"][node], "EXT_mesh_gpu_instancing");
    if (!extension) return {world};
    const std::string place =
        fmt::format("nodes[{}].extensions.EXT_mesh_gpu_instancing.attributes", node);
    const json& attributes = (*extension)["attributes"];
    std::optional<size_t> count;
    const auto read = [&]<class T>(const char* name, std::vector<T>& values) {
        if (!attributes.contains(name)) return;
        const std::string at = place + "." + name;
        values = read_floats<T>(document, attributes[name], at);
        if (count.value_or(values.size()) != values.size()) {
            document.fail(at, fmt::format("{} instances, but {} elsewhere", values.size(), *count));
        }
        count = values.size();
    };
    std::vector<Vec3> translations, scales;
    std::vector<Vec4> rotations;
    read("TRANSLATION", translations);
    read("ROTATION", rotations);
    read("SCALE", scales);
    // Many nodes may name the same few numbers.
    document.spend(place, count.value_or(0) * (sizeof(Instance) / sizeof(float)));
    std::vector<Mat4d> matrices(count.value_or(0));
    for (size_t i = 0; i < matrices.size(); ++i) {
        std::array<double, 4> rotation{0, 0, 0, 1};
        if (!rotations.empty()) {
            for (unsigned c = 0; c < 4; ++c) rotation[c] = double(rotations[i][int(c)]);
        }
        matrices[i] = compose(translations.empty() ? Vec3d(0) : Vec3d(translations[i]), rotation,
                              scales.empty() ? Vec3d(1) : Vec3d(scales[i])) *
                      world;
        if (!is_finite(matrices[i])) {
            document.fail(place, fmt::format("instance {} has no finite matrix", i));
        }
    }
    return matrices;
}

}  // namespace sightline
