#include "scene/gltf/all_faults.h"

#include "scene/gltf/animation.h"
#include "scene/gltf/cameras_lights.h"
#include "scene/gltf/images.h"
#include "scene/gltf/material.h"
#include "scene/gltf/mesh.h"
#include "scene/gltf/nodes.h"
#include "scene/gltf/pose.h"
#include "scene/gltf/shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <set>

namespace sightline {
namespace {

using nlohmann::json;

// Indices into Scene::materials: the primitive's own, and those of its variants.
std::set<uint32_t> materials_of(const GltfPrimitive& primitive, const json& source) {
    std::set<uint32_t> materials{primitive.material == none ? 0 : primitive.material + 1};
    if (const json* variants = find_extension(source, "KHR_materials_variants"))
        for (const json& mapping : (*variants)["mappings"])
            materials.insert(mapping["material"].get<uint32_t>() + 1);
    return materials;
}

class MeshReader {
  public:
    MeshReader(Document& document, const std::vector<Material>& materials,
               const std::vector<Mat4d>& world)
        : document_(document), materials_(materials), world_(world) {}

    // Reads the node's mesh, unless one with the same skin and count of weights has been read.
    void read(uint32_t index) {
        const GltfNode& node = document_.nodes[index];
        if (node.mesh == none) return;
        const GltfMesh& mesh = document_.meshes[node.mesh];
        const std::vector<float>& weights = node.weights.empty() ? mesh.weights : node.weights;
        if (!seen_.insert({node.mesh, node.skin, weights.size()}).second) return;
        std::vector<Mat4d> joints;
        if (node.skin != none) joints = joint_matrices(document_.skins[node.skin], world_);
        for (size_t p = 0; p < mesh.primitives.size(); ++p) {
            // All targets at work, and where their count differs also the weights as they are.
            const size_t targets = mesh.primitives[p].targets.size();
            const std::vector<float> all(targets, 1.0f);
            const std::vector<Mat4d>* posed_by = node.skin == none ? nullptr : &joints;
            read_with(node.mesh, p, {all, posed_by, {}, world_[index]});
            if (!weights.empty() && weights.size() != targets)
                read_with(node.mesh, p, {weights, posed_by, {}, world_[index]});
        }
    }

  private:
    void read_with(uint32_t mesh, size_t p, const MeshPose& pose) {
        const GltfPrimitive& primitive = document_.meshes[mesh].primitives[p];
        const json& source = document_.json["meshes"][mesh]["primitives"][p];
        for (const uint32_t material : materials_of(primitive, source)) {
            try {
                read_primitive(document_, primitive, source,
                               fmt::format("meshes[{}].primitives[{}]", mesh, p),
                               materials_[material], pose);
            } catch (const FaultyPart& part) {
                document_.report(part);
            }
        }
    }

    Document& document_;
    const std::vector<Material>& materials_;
    const std::vector<Mat4d>& world_;
    std::set<std::tuple<uint32_t, uint32_t, size_t>> seen_;
};

void check_animations_at_work(Document& document) {
    const std::vector<GltfNode> rest = document.nodes;
    animate(document, "all", 0);
    document.nodes = rest;
}

}  // namespace

void report_all_faults(Document& document, const LoadOptions& options) {
    document.budget = ReadBudget{options.max_accessor_values};
    check_animations_at_work(document);
    const std::vector<Mat4d> world = world_matrices(document);
    std::vector<uint32_t> nodes(document.nodes.size());
    std::iota(nodes.begin(), nodes.end(), 0u);
    read_cameras(document, nodes, world);
    read_lights(document, nodes, world);
    const std::vector<Material> materials = read_materials(document, read_textures(document));
    MeshReader meshes(document, materials, world);
    for (const uint32_t node : nodes) {
        if (document.nodes[node].mesh != none || node_shape(document, node))
            instance_matrices(document, node, world[node]);
        meshes.read(node);
    }
    check_images(document, options);
}

}  // namespace sightline
