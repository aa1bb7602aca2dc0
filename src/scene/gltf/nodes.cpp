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

// p' = p * M: scale, then rotation, then translation.
Mat4d compose(const Vec3d& translation, const std::array<double, 4>& rotation, const Vec3d& scale) {
    auto [x, y, z, w] = rotation;
    const double length = std::sqrt(x * x + y * y + z * z + w * w);
    if (length > 0 && std::isfinite(length))
        x /= length, y /= length, z /= length, w /= length;
    else
        x = y = z = 0, w = 1;
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

// The scene that `options` selects; nullptr if the file has none.
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
        for (uint32_t i = 0; i < document.nodes.size(); ++i)
            if (document.nodes[i].parent == none) roots.push_back(i);
    }
    return roots;
}

bool is_hidden(const json& node) {
    const json* visibility = find_extension(node, "KHR_node_visibility");
    return visibility && !visibility->value("visible", true);
}

// The number of instances that none of TRANSLATION, ROTATION and SCALE gives, which are optional:
// that of the application's own attributes.
size_t custom_instance_count(Document& document, const json& attributes, const std::string& place) {
    if (attributes.empty()) {
        document.warn(place, "is empty: drawn once");
        return 1;
    }
    const auto count_of = [&](const json& accessor) {
        document.require_usable(accessor, Fault::instances, place);
        return document.accessors[accessor.get<size_t>()].count;
    };
    const size_t count = count_of(attributes.front());
    for (const auto& [name, accessor] : attributes.items()) {
        if (count_of(accessor) == count) continue;
        document.fail_part(
            Fault::instances, place + "." + name,
            fmt::format("{} instances, but {} elsewhere", count_of(accessor), count));
    }
    return count;
}

// The attributes of EXT_mesh_gpu_instancing; each is empty or has `count` values.
struct InstanceTransforms {
    size_t count = 0;
    std::vector<Vec3> translations, scales;
    std::vector<Vec4> rotations;

    Mat4d matrix(size_t i) const {
        std::array<double, 4> rotation{0, 0, 0, 1};
        if (!rotations.empty())
            for (unsigned c = 0; c < 4; ++c) rotation[c] = double(rotations[i][int(c)]);
        return compose(translations.empty() ? Vec3d(0) : Vec3d(translations[i]), rotation,
                       scales.empty() ? Vec3d(1) : Vec3d(scales[i]));
    }
};

InstanceTransforms read_instances(Document& document, const json& attributes,
                                  const std::string& place) {
    InstanceTransforms instances;
    std::optional<size_t> count;
    const auto read = [&]<class T>(const char* name, std::vector<T>& values) {
        if (!attributes.contains(name)) return;
        const std::string at = place + "." + name;
        values = read_floats<T>(document, attributes[name], Fault::instances, at);
        if (count.value_or(values.size()) != values.size())
            document.fail_part(
                Fault::instances, at,
                fmt::format("{} instances, but {} elsewhere", values.size(), *count));
        count = values.size();
    };
    read("TRANSLATION", instances.translations);
    read("ROTATION", instances.rotations);
    read("SCALE", instances.scales);
    instances.count = count ? *count : custom_instance_count(document, attributes, place);
    // Many nodes can share the same few numbers.
    document.charge(place, instances.count * (sizeof(Instance) / sizeof(float)));
    return instances;
}

}  // namespace

Mat4d local_matrix(const GltfNode& node) {
    if (!node.has_matrix) return compose(node.translation, node.rotation, node.scale);
    Mat4d m = node.matrix;
    for (int r = 0; r < 3; ++r) m[r][3] = 0;  // affine, even if the file's matrix is not
    m[3][3] = 1;
    return m;
}

std::vector<Mat4d> world_matrices(Document& document) {
    const std::vector<GltfNode>& nodes = document.nodes;
    std::vector<Mat4d> world(nodes.size());
    std::vector<uint32_t> open;
    for (uint32_t i = 0; i < nodes.size(); ++i)
        if (nodes[i].parent == none) open.push_back(i);
    while (!open.empty()) {
        const uint32_t i = open.back();
        open.pop_back();
        const uint32_t parent = nodes[i].parent;
        world[i] = local_matrix(nodes[i]);
        if (parent != none) world[i] = world[i] * world[parent];
        if (!is_finite(world[i])) {
            document.report(Fault::matrix_not_finite, fmt::format("nodes[{}]", i),
                            "its matrix to world space is not finite");
            document.drop_nodes(i);
            world[i] = {};
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

Vec3d world_axis(const Mat4d& world, const Vec3d& axis) {
    Vec3d d;
    world.multDirMatrix(axis, d);
    const double length = std::sqrt(dot(d, d));
    return length > 0 && std::isfinite(length) ? d / length : axis;
}

std::optional<Vec3> scene_background(Document& document, const LoadOptions& options) {
    const json* scene = chosen_scene(document, options);
    const json* background = scene ? find_extension(*scene, "SIGHTLINE_background") : nullptr;
    if (!background) return {};
    const std::array<float, 3> color = (*background)["color"];
    return Vec3(color[0], color[1], color[2]);
}

std::vector<Mat4d> instance_matrices(Document& document, uint32_t node, const Mat4d& world) {
    const json* extension = find_extension(document.json["nodes"][node], "EXT_mesh_gpu_instancing");
    if (!extension) return {world};
    const std::string place =
        fmt::format("nodes[{}].extensions.EXT_mesh_gpu_instancing.attributes", node);
    InstanceTransforms instances;
    try {
        instances = read_instances(document, (*extension)["attributes"], place);
    } catch (const FaultyPart& part) {
        document.report(part);
        return {world};
    }
    std::vector<Mat4d> matrices;
    matrices.reserve(instances.count);
    for (size_t i = 0; i < instances.count; ++i) {
        const Mat4d matrix = instances.matrix(i) * world;
        if (is_finite(matrix))
            matrices.push_back(matrix);
        else
            document.report(Fault::instance, place,
                            fmt::format("instance {} has no finite matrix", i));
    }
    return matrices;
}

}  // namespace sightline
