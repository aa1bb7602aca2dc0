#include "scene/gltf/build.h"

#include "core/text.h"
#include "scene/gltf/cameras_lights.h"
#include "scene/gltf/contents.h"
#include "scene/gltf/flat.h"
#include "scene/gltf/material.h"
#include "scene/gltf/mesh.h"
#include "scene/gltf/nodes.h"
#include "scene/gltf/pose.h"
#include "scene/gltf/shapes.h"
#include "scene/shape_bounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace sightline {
namespace {

using nlohmann::json;

// A use of a mesh: all instances that share its geometry. A node with morph weights of its own has
// a use of its own.
struct MeshUse {
    uint32_t mesh = none;
    uint32_t node = none;                               // the first with this use
    std::vector<std::pair<uint32_t, Mat4d>> instances;  // node, matrix to world space
    Frame frame;                                        // of object space

    bool is_baked() const { return instances.size() == 1; }
};

std::optional<uint32_t> find_variant(const Document& document, const std::string& name) {
    if (name.empty()) return {};
    const std::vector<std::string> names = variant_names(document);
    if (const auto found = find_choice(names, name)) return static_cast<uint32_t>(*found);
    document.fail(
        "extensions.KHR_materials_variants",
        fmt::format("there is no variant \"{}\"; the file has {}", name, list_choices(names)));
}

// A primitive's index into Scene::materials.
uint32_t material_index(const Document& document, uint32_t mesh, size_t primitive,
                        std::optional<uint32_t> variant) {
    const json& source = document.json["meshes"][mesh]["primitives"][primitive];
    const json* extension = find_extension(source, "KHR_materials_variants");
    if (variant && extension) {
        for (const json& mapping : (*extension)["mappings"]) {
            for (const json& v : mapping["variants"])
                if (v == *variant) return mapping["material"].get<uint32_t>() + 1;
        }
    }
    const uint32_t material = document.meshes[mesh].primitives[primitive].material;
    return material == none ? 0 : material + 1;
}

bool has_targets(const GltfMesh& mesh) {
    return std::ranges::any_of(mesh.primitives, [](const auto& p) { return !p.targets.empty(); });
}

void warn_of_instancing(Document& document, uint32_t skinned_node) {
    constexpr const char* name = "EXT_mesh_gpu_instancing";
    if (!find_extension(document.json["nodes"][skinned_node], name)) return;
    document.warn(fmt::format("nodes[{}].extensions.{}", skinned_node, name),
                  "is ignored: its mesh has a skin");
}

// Sets the matrices in float; false if the inverse does not exist.
bool set_matrices(Instance& instance, const Mat4d& matrix) {
    const Mat4d inverse = matrix.inverse();  // the identity where there is none
    const double determinant = matrix.determinant();
    if (determinant == 0) return false;
    instance.mirrored = determinant < 0;
    for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) {
            instance.object_to_world[r][c] = static_cast<float>(matrix[r][c]);
            instance.world_to_object[r][c] = static_cast<float>(inverse[r][c]);
            if (!std::isfinite(instance.world_to_object[r][c])) return false;
        }
    }
    return true;
}

// Moves instances that a matrix flattens into uses of their own, which are baked: rays cannot be
// taken to the object space of a matrix without an inverse. Nor of one that is nearly flat: an
// inverse that stretches one direction k times more than another multiplies the rounding of rays,
// 2⁻²⁴, by up to k, which at 2¹⁶ is a 256th of the object's size.
void split_flat_instances(std::vector<MeshUse>& uses) {
    const auto is_round = [](const auto& instance) {
        Instance floats;
        return condition_of(instance.second) <= 0x1p16 && set_matrices(floats, instance.second);
    };
    const size_t count = uses.size();
    for (size_t i = 0; i < count; ++i) {
        if (uses[i].is_baked()) continue;
        auto& all = uses[i].instances;
        const auto flat = std::stable_partition(all.begin(), all.end(), is_round);
        const std::vector<std::pair<uint32_t, Mat4d>> split(flat, all.end());
        all.erase(flat, all.end());
        const uint32_t mesh = uses[i].mesh;
        for (const auto& instance : split) uses.push_back({mesh, instance.first, {instance}, {}});
    }
}

// Nodes with the same mesh, skin and morph weights share the geometry.
std::vector<MeshUse> collect_mesh_uses(Document& document, const std::vector<uint32_t>& nodes,
                                       const std::vector<Mat4d>& world) {
    std::vector<MeshUse> uses;
    std::map<std::array<uint32_t, 3>, size_t> index_of;
    for (const uint32_t i : nodes) {
        const GltfNode& node = document.nodes[i];
        if (node.mesh == none) continue;
        const bool morphs = !node.weights.empty() && has_targets(document.meshes[node.mesh]);
        const auto [index, is_new] =
            index_of.try_emplace({node.mesh, node.skin, morphs ? i : none}, uses.size());
        if (is_new) uses.push_back({node.mesh, i, {}, {}});
        auto& instances = uses[index->second].instances;
        if (node.skin == none) {
            for (const Mat4d& m : instance_matrices(document, i, world[i]))
                instances.emplace_back(i, m);
        } else {  // transformed by its joints alone
            if (instances.empty()) instances.emplace_back(i, Mat4d());
            warn_of_instancing(document, i);
        }
    }
    split_flat_instances(uses);
    return uses;
}

void warn_of_lost_area(Document& document, uint32_t node) {
    document.warn(fmt::format("nodes[{}]", node), "is scaled to a line or a point: not drawn");
}

// The largest coordinate that is drawn, in the scene's frame.
float coordinate_limit(const Scene& scene) {
    return static_cast<float>(double(max_coordinate) * scene.frame.scale);
}

bool is_in_range(const Box3& box, float limit) {
    const Box3 limits{Vec3(-limit), Vec3(limit)};
    return box.isEmpty() || (limits.intersects(box.min) && limits.intersects(box.max));
}

// The world-space bounds of a primitive's vertices; of those in range, if some are not.
Box3 world_bounds(const PrimitiveMesh& primitive, const Mat4d& matrix, float limit) {
    Box3 box = transformed_box(primitive.bounds, matrix);
    if (is_in_range(box, limit)) return box;
    Box3 result;
    for (const Vec3& p : primitive.mesh.positions) {
        const Vec3 vertex(Vec3d(p) * matrix);
        if (is_in_range({vertex, vertex}, limit)) result.extendBy(vertex);
    }
    return result;
}

// The mesh's primitives that have triangles to draw, in world space if the use is baked. Extends
// the scene's bounds by all their vertices.
std::vector<Mesh> read_meshes(Document& document, const MeshUse& use,
                              const std::vector<Mat4d>& world, std::optional<uint32_t> variant,
                              Scene& scene) {
    const GltfMesh& source = document.meshes[use.mesh];
    const GltfNode& first = document.nodes[use.node];
    std::vector<Mat4d> joints;
    if (first.skin != none) joints = joint_matrices(document.skins[first.skin], world);
    const MeshPose pose{first.weights.empty() ? source.weights : first.weights,
                        first.skin == none ? nullptr : &joints, use.frame, world[use.node]};
    const float limit = coordinate_limit(scene);
    std::vector<Mesh> meshes;
    for (size_t i = 0; i < source.primitives.size(); ++i) {
        const std::string place = fmt::format("meshes[{}].primitives[{}]", use.mesh, i);
        const uint32_t material = material_index(document, use.mesh, i, variant);
        PrimitiveMesh primitive;
        try {
            primitive = read_primitive(document, source.primitives[i],
                                       document.json["meshes"][use.mesh]["primitives"][i], place,
                                       scene.materials[material], pose);
        } catch (const FaultyPart& part) {
            document.report(part);
            continue;
        }
        for (const auto& [node, matrix] : use.instances)
            scene.bounds.extendBy(world_bounds(primitive, matrix, limit));
        if (use.is_baked()) {
            if (!has_area(use.instances[0].second)) continue;
            transform_mesh(primitive.mesh, use.instances[0].second);
            drop_out_of_range_triangles(document, primitive.mesh, place, limit);
        }
        if (primitive.mesh.triangles.empty()) continue;
        primitive.mesh.material = material;
        primitive.mesh.name = source.name;
        primitive.mesh.positions.reserve(primitive.mesh.positions.size() + 1);
        meshes.push_back(std::move(primitive.mesh));
    }
    return meshes;
}

// Adds a group, its meshes and its instances to the scene.
void add_mesh_use(Document& document, const MeshUse& use, std::vector<Mesh> meshes, Scene& scene) {
    for (const auto& [node, matrix] : use.instances)
        if (!has_area(matrix)) warn_of_lost_area(document, node);
    if (meshes.empty()) return;
    Group& group = scene.groups.emplace_back();
    for (Mesh& mesh : meshes) {
        group.meshes.push_back(static_cast<uint32_t>(scene.meshes.size()));
        scene.meshes.push_back(std::move(mesh));
    }
    for (const auto& [node, matrix] : use.instances) {
        Instance instance;
        instance.group = static_cast<uint32_t>(scene.groups.size() - 1);
        instance.baked = use.is_baked();
        if (!instance.baked) set_matrices(instance, matrix);
        instance.name = document.nodes[node].name;
        if (instance.name.empty()) instance.name = document.meshes[use.mesh].name;
        scene.instances.push_back(std::move(instance));
    }
}

// Measures object space from the use's frame.
void choose_object_frame(const Document& document, const Placement& placement, MeshUse& use) {
    if (use.instances.empty() || document.nodes[use.node].skin != none) return;
    Box3 bounds;
    for (const GltfPrimitive& primitive : document.meshes[use.mesh].primitives) {
        const auto accessor = primitive.attributes.find("POSITION");
        if (accessor == primitive.attributes.end()) continue;
        const auto found = placement.position_bounds.find(accessor->second);
        if (found != placement.position_bounds.end()) bounds.extendBy(found->second);
    }
    use.frame = object_frame(bounds, use.instances.front().second, !use.is_baked(), placement);
    if (use.frame.is_identity()) return;
    const Mat4d back = use.frame.from_frame();
    for (auto& [node, matrix] : use.instances) matrix = back * matrix;
}

// The same for a shape: gives it a size that floats suit, and the inverse to its matrix.
void choose_object_frame(const Placement& placement, Shape& shape, Mat4d& matrix) {
    if (is_endless(shape)) return;
    const Frame frame = object_frame(shape_bounds(shape), matrix, false, placement);
    if (frame.is_identity()) return;
    const auto scale = static_cast<float>(frame.scale);
    for (float* length : {&shape.radius, &shape.tube_radius, &shape.height, &shape.radius_top,
                          &shape.radius_bottom, &shape.scale})
        *length *= scale;
    shape.size *= scale;
    matrix = frame.from_frame() * matrix;
}

// Lights are sampled on triangles.
void warn_if_it_emits(Document& document, const Material& material, uint32_t node) {
    if (material.unlit || is_black(material.emissive_factor)) return;
    document.warn(
        fmt::format("nodes[{}]", node),
        "an emissive shape shines, but diffuse surfaces do not get its light: use a mesh");
}

// Shapes are small: each instance is a shape of its own, in world space.
void add_shape(Document& document, Shape shape, const Mat4d& matrix, uint32_t node, Scene& scene) {
    if (!has_area(matrix)) return warn_of_lost_area(document, node);
    if (!transform_shape(shape, matrix) && !transform_shape(shape, thickened(matrix)))
        return document.warn(fmt::format("nodes[{}]", node), "has a singular matrix: not drawn");
    const Box3 bounds = shape_bounds(shape);
    if (!is_in_range(bounds, coordinate_limit(scene))) {
        return document.warn(fmt::format("nodes[{}]", node),
                             "is too large or too far away: not drawn");
    }
    if (!is_endless(shape)) scene.bounds.extendBy(bounds);
    Group& group = scene.groups.emplace_back();
    group.shapes.push_back(static_cast<uint32_t>(scene.shapes.size()));
    Instance& instance = scene.instances.emplace_back();
    instance.group = static_cast<uint32_t>(scene.groups.size() - 1);
    instance.baked = true;
    instance.name = shape.name;
    scene.shapes.push_back(std::move(shape));
}

// Takes the lengths of what was read to the scene's unit, and intensities with them: I / d² stays.
void scale_lengths(Scene& scene) {
    const double scale = scene.frame.scale;
    if (scale == 1) return;
    const auto multiply = [](float& value, double by) {
        const double product = double(value) * by;
        const double largest = double(std::numeric_limits<float>::max());
        value = static_cast<float>(std::isinf(value) ? product : std::min(product, largest));
    };
    for (Material& material : scene.materials) multiply(material.attenuation_distance, scale);
    for (Light& light : scene.lights) {
        multiply(light.range, scale);
        if (light.kind != LightKind::directional) multiply(light.intensity, scale * scale);
    }
    for (Camera& camera : scene.cameras)
        for (float* length : {&camera.xmag, &camera.ymag, &camera.znear, &camera.zfar})
            multiply(*length, scale);
}

}  // namespace

Scene build_scene(Document& document, const LoadOptions& options, const Placement& placement) {
    std::vector<Mat4d> world = world_matrices(document);
    if (!placement.frame.is_identity())
        for (Mat4d& matrix : world) matrix *= placement.frame.to_frame();
    const std::optional<uint32_t> variant = find_variant(document, options.variant);
    Scene scene;
    scene.path = document.path;
    scene.frame = placement.frame;
    scene.textures = read_textures(document);
    scene.materials = read_materials(document, scene.textures);
    const std::vector<uint32_t> nodes = visible_nodes(document, options);
    scene.cameras = read_cameras(document, nodes, world);
    scene.lights = read_lights(document, nodes, world);
    scale_lengths(scene);
    for (MeshUse& use : collect_mesh_uses(document, nodes, world)) {
        if (use.instances.empty()) continue;
        choose_object_frame(document, placement, use);
        add_mesh_use(document, use, read_meshes(document, use, world, variant, scene), scene);
    }
    for (const uint32_t node : nodes) {
        const std::optional<Shape> shape = node_shape(document, node);
        if (!shape) continue;
        warn_if_it_emits(document, scene.materials[shape->material], node);
        for (Mat4d& matrix : instance_matrices(document, node, world[node])) {
            Shape placed = *shape;
            choose_object_frame(placement, placed, matrix);
            add_shape(document, placed, matrix, node, scene);
        }
    }
    scene.background = scene_background(document, options);
    scene.contents = read_contents(document);
    return scene;
}

}  // namespace sightline
