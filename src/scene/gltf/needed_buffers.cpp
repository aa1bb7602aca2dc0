#include "scene/gltf/needed_buffers.h"

#include "scene/gltf/meshopt.h"

namespace sightline {
namespace {

using nlohmann::json;

// Follows accessors and buffer views to the buffers that hold their bytes.
class BufferNeeds {
  public:
    explicit BufferNeeds(const Document& document)
        : document_(document), needed_(document.list("buffers").size(), false) {}

    void add_view(uint32_t index) {
        if (index == none || document_.buffer_views[index].dropped) return;
        const json* stream = find_meshopt(document_.json["bufferViews"][index]);
        needed_[stream ? (*stream)["buffer"].get<uint32_t>()
                       : document_.buffer_views[index].buffer] = true;
    }

    void add_accessor(uint32_t index) {
        if (index == none) return;
        const GltfAccessor& accessor = document_.accessors[index];
        add_view(accessor.buffer_view);
        if (accessor.sparse.count == 0) return;
        add_view(accessor.sparse.indices_view);
        add_view(accessor.sparse.values_view);
    }

    void add_primitive(const GltfPrimitive& primitive, const json& source) {
        for (const auto& [name, accessor] : primitive.attributes) add_accessor(accessor);
        for (const auto& target : primitive.targets)
            for (const auto& [name, accessor] : target) add_accessor(accessor);
        add_accessor(primitive.indices);
        if (const json* draco = find_extension(source, "KHR_draco_mesh_compression"))
            add_view((*draco)["bufferView"]);
    }

    std::vector<bool> take() { return std::move(needed_); }

  private:
    const Document& document_;
    std::vector<bool> needed_;
};

}  // namespace

std::vector<bool> needed_buffers(const Document& document, bool animated) {
    BufferNeeds needs(document);
    for (size_t m = 0; m < document.meshes.size(); ++m)
        for (size_t p = 0; p < document.meshes[m].primitives.size(); ++p)
            needs.add_primitive(document.meshes[m].primitives[p],
                                document.json["meshes"][m]["primitives"][p]);
    for (const GltfSkin& skin : document.skins) needs.add_accessor(skin.inverse_bind_matrices);
    for (const json& node : document.list("nodes"))
        if (const json* instances = find_extension(node, "EXT_mesh_gpu_instancing"))
            for (const json& accessor : (*instances)["attributes"]) needs.add_accessor(accessor);
    for (const json& image : document.list("images"))
        if (image.contains("bufferView")) needs.add_view(image["bufferView"]);
    for (const GltfAnimation& animation : document.animations) {
        if (!animated) break;
        for (const GltfAnimation::Sampler& sampler : animation.samplers) {
            needs.add_accessor(sampler.input);
            needs.add_accessor(sampler.output);
        }
    }
    return needs.take();
}

}  // namespace sightline
