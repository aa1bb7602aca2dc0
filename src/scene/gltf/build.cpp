#include "scene/gltf/build.h"

#include "core/text.h"
#include "scene/gltf/animation.h"
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
#include <utility>

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

UsePose pose_of(const Document& document, const MeshUse& use, const std::vector<Mat4d>& world) {
    const GltfNode& first = document.nodes[use.node];
    UsePose pose;
    pose.mesh = use.mesh;
    pose.skinned = first.skin != none;
    if (pose.skinned) pose.joints = joint_matrices(document.skins[first.skin], world);
    pose.weights = first.weights.empty() ? document.meshes[use.mesh].weights : first.weights;
    pose.to_frame = use.frame.to_frame();
    if (use.is_baked()) pose.matrix = use.instances[0].second;
    return pose;
}

// Reads the mesh's primitives that have triangles to draw, in world space if the use is baked.
// Extends the scene's bounds by all their vertices.
std::vector<Mesh> read_meshes(Document& document, const MeshUse& use, const Mat4d& node_to_world,
                              std::optional<uint32_t> variant,
                              const std::vector<Material>& materials, Scene& scene,
                              BuiltUse& built) {
    const GltfMesh& source = document.meshes[use.mesh];
    const MeshPose pose{built.pose.weights, built.pose.skinned ? &built.pose.joints : nullptr,
                        use.frame, node_to_world};
    const float limit = coordinate_limit(scene);
    const uint64_t reports = document.reports;
    std::vector<Mesh> meshes;
    for (size_t i = 0; i < source.primitives.size(); ++i) {
        const std::string place = fmt::format("meshes[{}].primitives[{}]", use.mesh, i);
        const uint32_t material = material_index(document, use.mesh, i, variant);
        PrimitiveMesh primitive;
        try {
            primitive = read_primitive(document, source.primitives[i],
                                       document.json["meshes"][use.mesh]["primitives"][i], place,
                                       materials[material], pose);
        } catch (const FaultyPart& part) {
            document.report(part);
            continue;
        }
        built.bounds.push_back(primitive.bounds);
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
    built.is_clean = document.reports == reports;
    return meshes;
}

// The same from the last pose, if nothing has changed that they depend on.
std::optional<std::vector<Mesh>> keep_meshes(const BuiltUse& last, const MeshUse& use,
                                             Scene& before, Scene& scene, BuiltUse& built) {
    if (!last.is_clean || last.pose != built.pose) return {};
    Box3 bounds;
    for (const Box3& box : last.bounds)
        for (const auto& [node, matrix] : use.instances)
            bounds.extendBy(transformed_box(box, matrix));
    if (!is_in_range(bounds, coordinate_limit(scene))) return {};
    scene.bounds.extendBy(bounds);
    built.bounds = last.bounds;
    built.is_clean = true;
    std::vector<Mesh> meshes;
    for (const uint32_t mesh : last.meshes) meshes.push_back(std::move(before.meshes[mesh]));
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

void multiply(float& value, double by) {
    const double product = double(value) * by;
    const double largest = double(std::numeric_limits<float>::max());
    value = static_cast<float>(std::isinf(value) ? product : std::min(product, largest));
}

// Takes the lengths of what was read to the scene's unit, and intensities with them: I / d² stays.
void scale_lengths(Scene& scene) {
    const double scale = scene.frame.scale;
    if (scale == 1) return;
    for (Light& light : scene.lights) {
        multiply(light.range, scale);
        if (light.kind != LightKind::directional) multiply(light.intensity, scale * scale);
    }
    for (Camera& camera : scene.cameras)
        for (float* length : {&camera.xmag, &camera.ymag, &camera.znear, &camera.zfar})
            multiply(*length, scale);
}

void add_shapes(Document& document, const std::vector<uint32_t>& nodes,
                const std::vector<Mat4d>& world, const Placement& placement, Scene& scene) {
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
}

// Takes what a pose decides out of a scene.
Scene take_posed(Scene& scene) {
    Scene posed;
    std::swap(posed.meshes, scene.meshes);
    std::swap(posed.shapes, scene.shapes);
    std::swap(posed.groups, scene.groups);
    std::swap(posed.instances, scene.instances);
    std::swap(posed.bounds, scene.bounds);
    return posed;
}

bool have_same_instances(const Scene& a, const Scene& b) {
    return std::ranges::equal(a.instances, b.instances, [](const Instance& x, const Instance& y) {
        return x.group == y.group && x.baked == y.baked && x.object_to_world == y.object_to_world;
    });
}

}  // namespace

ScenePoser::ScenePoser(Document& document, const LoadOptions& options, bool several)
    : document_(document),
      options_(options),
      placement_(place_scene(document, options)),
      variant_(find_variant(document, options.variant)),
      textures_(read_textures(document)),
      materials_(read_materials(document, textures_)) {
    if (const double scale = placement_.frame.scale; scale != 1)
        for (Material& material : materials_) multiply(material.attenuation_distance, scale);
    if (several) rest_ = document_.save();
}

// Adds groups, meshes and instances. Returns whether all meshes are those of `before`.
bool ScenePoser::add_meshes(const std::vector<uint32_t>& nodes, const std::vector<Mat4d>& world,
                            Scene& before, Scene& scene) {
    std::vector<BuiltUse> last = std::exchange(built_, {});
    bool all_kept = true;
    for (MeshUse& use : collect_mesh_uses(document_, nodes, world)) {
        if (use.instances.empty()) continue;
        choose_object_frame(document_, placement_, use);
        const size_t i = built_.size();
        BuiltUse& built = built_.emplace_back();
        built.pose = pose_of(document_, use, world);
        std::optional<std::vector<Mesh>> meshes;
        if (i < last.size()) meshes = keep_meshes(last[i], use, before, scene, built);
        all_kept &= meshes.has_value();
        if (!meshes)
            meshes =
                read_meshes(document_, use, world[use.node], variant_, materials_, scene, built);
        for (size_t m = 0; m < meshes->size(); ++m)
            built.meshes.push_back(static_cast<uint32_t>(scene.meshes.size() + m));
        add_mesh_use(document_, use, std::move(*meshes), scene);
    }
    return all_kept && built_.size() == last.size();
}

bool ScenePoser::pose(std::optional<float> time, Scene& scene) {
    if (rest_) document_.restore(*rest_);
    if (time || !options_.animation.empty())
        animate(document_, options_.animation, double(time.value_or(0)));
    std::vector<Mat4d> world = world_matrices(document_);
    if (!placement_.frame.is_identity())
        for (Mat4d& matrix : world) matrix *= placement_.frame.to_frame();
    if (scene.materials.empty()) {
        scene.path = document_.path;
        scene.frame = placement_.frame;
        scene.textures = textures_;
        scene.materials = materials_;
        scene.contents = read_contents(document_);
    }
    Scene before = take_posed(scene);
    const std::vector<uint32_t> nodes = visible_nodes(document_, options_);
    scene.cameras = read_cameras(document_, nodes, world);
    scene.lights = read_lights(document_, nodes, world);
    scale_lengths(scene);
    const bool all_kept = add_meshes(nodes, world, before, scene);
    add_shapes(document_, nodes, world, placement_, scene);
    scene.background = scene_background(document_, options_);
    return !all_kept || !scene.shapes.empty() || !have_same_instances(before, scene);
}

}  // namespace sightline
