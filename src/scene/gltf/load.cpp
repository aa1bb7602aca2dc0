#include "scene/gltf/load.h"

#include "core/error.h"
#include "core/text.h"
#include "scene/gltf/contents.h"
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
#include <map>
#include <new>

namespace sightline {
namespace {

using nlohmann::json;

// A mesh and all the places where it is drawn. An individually morphed node has its own.
struct Placed {
    uint32_t mesh = none;
    uint32_t node = none;                            // the first that draws it
    std::vector<std::pair<uint32_t, Mat4d>> places;  // node, matrix
};

std::optional<uint32_t> find_variant(const Document& document, const std::string& name) {
    if (name.empty()) return {};
    const std::vector<std::string> names = variant_names(document);
    if (const auto found = find_choice(names, name)) return static_cast<uint32_t>(*found);
    document.fail(
        "extensions.KHR_materials_variants",
        fmt::format("there is no variant \"{}\"; the file has {}", name, list_choices(names)));
}

// Index into Scene::materials.
uint32_t material_of(const Document& document, uint32_t mesh, size_t primitive,
                     std::optional<uint32_t> variant) {
    const json& source = document.json["meshes"][mesh]["primitives"][primitive];
    const json* extension = find_extension(source, "KHR_materials_variants");
    if (variant && extension) {
        for (const json& mapping : (*extension)["mappings"]) {
            for (const json& v : mapping["variants"]) {
                if (v == *variant) return mapping["material"].get<uint32_t>() + 1;
            }
        }
    }
    const uint32_t material = document.meshes[mesh].primitives[primitive].material;
    return material == none ? 0 : material + 1;
}

std::string place_of(uint32_t mesh, size_t primitive) {
    return fmt::format("meshes[{}].primitives[{}]", mesh, primitive);
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

// Nodes whose mesh, skin and morph weights are the same share the geometry.
std::vector<Placed> collect_placed(Document& document, const std::vector<uint32_t>& nodes,
                                   const std::vector<Mat4d>& world) {
    std::vector<Placed> placed;
    std::map<std::array<uint32_t, 3>, size_t> index_of;
    for (const uint32_t i : nodes) {
        const GltfNode& node = document.nodes[i];
        if (node.mesh == none) continue;
        const bool morphs = !node.weights.empty() && has_targets(document.meshes[node.mesh]);
        const auto [index, is_new] =
            index_of.try_emplace({node.mesh, node.skin, morphs ? i : none}, placed.size());
        if (is_new) placed.push_back({node.mesh, i, {}});
        std::vector<std::pair<uint32_t, Mat4d>>& places = placed[index->second].places;
        if (node.skin == none) {
            for (const Mat4d& m : placements(document, i, world[i])) places.emplace_back(i, m);
        } else {  // its joints alone place it
            if (places.empty()) places.emplace_back(i, Mat4d());
            warn_of_instancing(document, i);
        }
    }
    return placed;
}

bool is_near(const Box3& box) {
    const Box3 limits(Vec3(-farthest), Vec3(farthest));
    return box.isEmpty() || (limits.intersects(box.min) && limits.intersects(box.max));
}

// What a placed primitive adds to the scene's bounds. Where the box of all its vertices reaches
// too far, that of those that do not.
Box3 placed_bounds(const PrimitiveMesh& primitive, const Mat4d& matrix) {
    const Box3 box = transformed_box(primitive.bounds, matrix);
    if (is_near(box)) return box;
    Box3 result;
    for (const Vec3& p : primitive.mesh.positions) {
        const Vec3 placed(Vec3d(p) * matrix);
        if (is_near({placed, placed})) result.extendBy(placed);
    }
    return result;
}

// The matrices in float; false where the inverse does not exist.
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

class SceneBuilder {
  public:
    SceneBuilder(Document& document, const LoadOptions& options)
        : document_(document),
          world_(world_matrices(document)),
          variant_(find_variant(document, options.variant)) {
        scene_.path = document.path;
        read_materials(document, scene_);
        material_used_.resize(scene_.materials.size(), false);
        const std::vector<uint32_t> nodes = visible_nodes(document, options);
        place_cameras_and_lights(document, nodes, world_, scene_);
        for (const Placed& placed : collect_placed(document, nodes, world_)) add(placed);
        for (const uint32_t node : nodes) add_shapes(node);
        scene_.background = scene_background(document, options);
        decode_images(document, material_used_, options, scene_);
        scene_.contents = read_contents(document);
        scene_.warnings = document.warnings.lines();
        scene_.files = document.files;
        scene_.content_hash = document.content_hash;
    }

    Scene take() { return std::move(scene_); }

  private:
    void add(const Placed& placed) {
        if (placed.places.empty()) return;
        const GltfMesh& mesh = document_.meshes[placed.mesh];
        const bool baked = placed.places.size() == 1;
        const GltfNode& first = document_.nodes[placed.node];
        std::vector<Mat4d> joints;
        if (first.skin != none) joints = joint_matrices(document_, first.skin, world_);
        const MeshPose pose{first.weights.empty() ? mesh.weights : first.weights,
                            first.skin == none ? nullptr : &joints};
        Group group;
        for (size_t i = 0; i < mesh.primitives.size(); ++i) {
            PrimitiveMesh primitive = read(placed, i, pose);
            for (const auto& [node, matrix] : placed.places) {
                scene_.bounds.extendBy(placed_bounds(primitive, matrix));
            }
            if (baked) bake(primitive.mesh, placed.places[0].second, place_of(placed.mesh, i));
            if (primitive.mesh.triangles.empty()) continue;
            material_used_[primitive.mesh.material] = true;
            primitive.mesh.positions.reserve(primitive.mesh.positions.size() + 1);
            group.meshes.push_back(static_cast<uint32_t>(scene_.meshes.size()));
            scene_.meshes.push_back(std::move(primitive.mesh));
        }
        if (group.meshes.empty()) return;
        scene_.groups.push_back(std::move(group));
        for (const auto& [node, matrix] : placed.places) add_instance(placed, node, matrix, baked);
    }

    PrimitiveMesh read(const Placed& placed, size_t index, const MeshPose& pose) {
        const GltfMesh& mesh = document_.meshes[placed.mesh];
        const uint32_t material = material_of(document_, placed.mesh, index, variant_);
        PrimitiveMesh primitive =
            read_primitive(document_, mesh.primitives[index], place_of(placed.mesh, index),
                           scene_.materials[material], pose);
        primitive.mesh.material = material;
        primitive.mesh.name = mesh.name;
        return primitive;
    }

    void bake(Mesh& mesh, const Mat4d& matrix, const std::string& place) {
        transform_mesh(mesh, matrix);
        leave_out_far_triangles(document_, mesh, place, farthest);
    }

    // Shapes are small: each is placed on its own, in world space.
    void add_shapes(uint32_t node) {
        const std::optional<Shape> shape = node_shape(document_, node);
        if (!shape) return;
        for (const Mat4d& matrix : placements(document_, node, world_[node]))
            add_shape(*shape, matrix, node);
    }

    void add_shape(Shape shape, const Mat4d& matrix, uint32_t node) {
        const std::string place = fmt::format("nodes[{}]", node);
        if (!place_shape(shape, matrix)) {
            return document_.warn(place, "is scaled to nothing: not drawn");
        }
        const Box3 bounds = shape_bounds(shape);
        if (!is_near(bounds)) {
            return document_.warn(place, "is too large or too far away: not drawn");
        }
        if (!is_endless(shape)) scene_.bounds.extendBy(bounds);
        material_used_[shape.material] = true;
        Group& group = scene_.groups.emplace_back();
        group.shapes.push_back(static_cast<uint32_t>(scene_.shapes.size()));
        Instance& instance = scene_.instances.emplace_back();
        instance.group = static_cast<uint32_t>(scene_.groups.size() - 1);
        instance.baked = true;
        instance.name = shape.name;
        scene_.shapes.push_back(std::move(shape));
    }

    void add_instance(const Placed& placed, uint32_t node, const Mat4d& matrix, bool baked) {
        Instance instance;
        instance.group = static_cast<uint32_t>(scene_.groups.size() - 1);
        instance.baked = baked;
        if (!baked && !set_matrices(instance, matrix)) {
            document_.warn(fmt::format("nodes[{}]", node), "is scaled to nothing: not drawn");
            return;
        }
        instance.name = document_.nodes[node].name;
        if (instance.name.empty()) instance.name = document_.meshes[placed.mesh].name;
        scene_.instances.push_back(std::move(instance));
    }

    Document& document_;
    std::vector<Mat4d> world_;
    std::optional<uint32_t> variant_;
    Scene scene_;
    std::vector<bool> material_used_;
};

}  // namespace

Scene load_gltf(const std::string& path, const LoadOptions& options) try {
    Document document = load_document(path, options);
    if (options.time || !options.animation.empty()) {
        animate(document, options.animation.empty() ? "all" : options.animation,
                double(options.time.value_or(0)));
    }
    return SceneBuilder(document, options).take();
} catch (const std::bad_alloc&) {
    throw Error(path + ": not enough memory to load it");
}

}  // namespace sightline
