#include "scene/gltf.h"

#include "core/error.h"
#include "scene/gltf_material.h"
#include "scene/gltf_mesh.h"
#include "scene/gltf_nodes.h"
#include "scene/gltf_shapes.h"
#include "scene/pose.h"
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
    const json* extension = find_extension(document.json, "KHR_materials_variants");
    std::string names;
    for (uint32_t i = 0; extension && i < (*extension)["variants"].size(); ++i) {
        const std::string candidate = (*extension)["variants"][i]["name"];
        if (candidate == name) return i;
        names += (names.empty() ? "" : ", ") + candidate;
    }
    document.fail("extensions.KHR_materials_variants",
                  fmt::format("there is no variant '{}' among: {}", name, names));
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

bool has_targets(const GltfMesh& mesh) {
    return std::ranges::any_of(mesh.primitives, [](const auto& p) { return !p.targets.empty(); });
}

// Nodes whose mesh, skin and morph weights are the same share the geometry.
std::vector<Placed> collect_placed(const Document& document, const std::vector<uint32_t>& nodes,
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
        } else if (places.empty()) {  // its joints alone place it
            places.emplace_back(i, Mat4d());
        }
    }
    return placed;
}

void extend_bounds(Scene& scene, const Box3& box, const Mat4d& matrix) {
    if (box.isEmpty()) return;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                     corner & 4 ? box.max.z : box.min.z);
        scene.bounds.extendBy(Vec3(Vec3d(p) * matrix));
    }
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
        for (const uint32_t node : nodes) add_shape(node);
        scene_.background = scene_background(document, options);
        decode_images(document, material_used_, options, scene_);
        scene_.warnings = document.warnings;
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
                extend_bounds(scene_, primitive.bounds, matrix);
            }
            if (primitive.mesh.triangles.empty()) continue;
            material_used_[primitive.mesh.material] = true;
            if (baked) transform_mesh(primitive.mesh, placed.places[0].second);
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
            read_primitive(document_, mesh.primitives[index],
                           fmt::format("meshes[{}].primitives[{}]", placed.mesh, index),
                           scene_.materials[material], pose);
        primitive.mesh.material = material;
        primitive.mesh.name = mesh.name;
        return primitive;
    }

    // Shapes are small: each is placed on its own, in world space.
    void add_shape(uint32_t node) {
        std::optional<Shape> shape = node_shape(document_, node);
        if (!shape) return;
        if (!place_shape(*shape, world_[node])) {
            document_.warn(fmt::format("nodes[{}]", node), "is scaled to nothing: not drawn");
            return;
        }
        const bool endless =
            shape->kind == ShapeKind::plane && (shape->size.x <= 0 || shape->size.z <= 0);
        if (!endless) scene_.bounds.extendBy(shape_bounds(*shape));
        material_used_[shape->material] = true;
        Group& group = scene_.groups.emplace_back();
        group.shapes.push_back(static_cast<uint32_t>(scene_.shapes.size()));
        Instance& instance = scene_.instances.emplace_back();
        instance.group = static_cast<uint32_t>(scene_.groups.size() - 1);
        instance.baked = true;
        instance.name = shape->name;
        scene_.shapes.push_back(std::move(*shape));
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
    if (options.time) {
        animate(document, options.animation.empty() ? "all" : options.animation,
                double(*options.time));
    }
    return SceneBuilder(document, options).take();
} catch (const std::bad_alloc&) {
    throw Error(path + ": not enough memory to load it");
}

}  // namespace sightline
