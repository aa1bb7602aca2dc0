// The only file that knows tinygltf. It parses what a scene is built of: views, accessors, nodes,
// meshes, skins and animations. It sees neither URIs nor images nor extensions, and nothing that
// check_structure has not seen before: it lets through too much, and cuts integers to 32 bits.
#include "scene/gltf/parse.h"

#include <tiny_gltf.h>

#include <algorithm>

namespace sightline {
namespace {

using nlohmann::json;

// A copy without what tinygltf need not or must not see. Primitives' indices are left out because
// it refuses those without a buffer view, which compressed and sparse ones may be.
json without_baggage(const json& value, bool primitive) {
    if (value.is_array()) {
        json copy = json::array();
        for (const json& item : value) copy.push_back(without_baggage(item, primitive));
        return copy;
    }
    if (!value.is_object()) return value;
    json copy = json::object();
    for (const auto& [key, item] : value.items()) {
        if (key == "extensions" || key == "extras" || (primitive && key == "indices")) continue;
        copy[key] = without_baggage(item, key == "primitives");
    }
    return copy;
}

tinygltf::Model parse(const Document& document) {
    json core = json::object();
    for (const char* key :
         {"asset", "bufferViews", "accessors", "meshes", "nodes", "skins", "animations"}) {
        if (document.json.contains(key)) core[key] = without_baggage(document.json[key], false);
    }
    const std::string text = core.dump();
    tinygltf::TinyGLTF parser;
    tinygltf::Model model;
    std::string error, warning;
    if (!parser.LoadASCIIFromString(&model, &error, &warning, text.c_str(),
                                    static_cast<unsigned>(text.size()), "",
                                    tinygltf::REQUIRE_VERSION)) {
        std::replace(error.begin(), error.end(), '\n', ' ');
        document.fail("JSON", error);
    }
    return model;
}

// tinygltf's −1 is our `none`.
uint32_t index(int i) { return i < 0 ? none : static_cast<uint32_t>(i); }

std::vector<uint32_t> indices(const std::vector<int>& list) { return {list.begin(), list.end()}; }

std::map<std::string, uint32_t> indices(const std::map<std::string, int>& list) {
    return {list.begin(), list.end()};
}

GltfBufferView convert(const tinygltf::BufferView& from) {
    GltfBufferView view;
    view.buffer = index(from.buffer);
    view.byte_offset = from.byteOffset;
    view.byte_length = from.byteLength;
    view.byte_stride = static_cast<uint32_t>(from.byteStride);
    return view;
}

GltfAccessor convert(const tinygltf::Accessor& from) {
    GltfAccessor a;
    a.buffer_view = index(from.bufferView);
    a.byte_offset = from.byteOffset;
    a.count = from.count;
    a.component_type = ComponentType{from.componentType};
    const bool matrix = from.type == TINYGLTF_TYPE_MAT2 || from.type == TINYGLTF_TYPE_MAT3 ||
                        from.type == TINYGLTF_TYPE_MAT4;
    const auto components =
        static_cast<uint32_t>(tinygltf::GetNumComponentsInType(static_cast<uint32_t>(from.type)));
    a.rows = !matrix ? components : components == 4 ? 2 : components == 9 ? 3 : 4;
    a.columns = matrix ? a.rows : 1;
    a.normalized = from.normalized;
    if (from.sparse.isSparse) {
        a.sparse.count = static_cast<uint64_t>(from.sparse.count);
        a.sparse.indices_view = index(from.sparse.indices.bufferView);
        a.sparse.indices_offset = static_cast<uint64_t>(from.sparse.indices.byteOffset);
        a.sparse.indices_type = ComponentType{from.sparse.indices.componentType};
        a.sparse.values_view = index(from.sparse.values.bufferView);
        a.sparse.values_offset = static_cast<uint64_t>(from.sparse.values.byteOffset);
    }
    return a;
}

GltfMesh convert(const tinygltf::Mesh& from, const json& source) {
    GltfMesh mesh;
    mesh.name = from.name;
    mesh.weights.assign(from.weights.begin(), from.weights.end());
    for (size_t i = 0; i < from.primitives.size(); ++i) {
        const tinygltf::Primitive& p = from.primitives[i];
        GltfPrimitive& primitive = mesh.primitives.emplace_back();
        primitive.attributes = indices(p.attributes);
        primitive.indices = source["primitives"][i].value("indices", none);
        primitive.material = index(p.material);
        primitive.mode = p.mode;
        for (const auto& target : p.targets) primitive.targets.push_back(indices(target));
    }
    return mesh;
}

GltfNode convert(const tinygltf::Node& from) {
    GltfNode node;
    node.name = from.name;
    node.children = indices(from.children);
    node.mesh = index(from.mesh);
    node.skin = index(from.skin);
    node.camera = index(from.camera);
    node.weights.assign(from.weights.begin(), from.weights.end());
    node.has_matrix = !from.matrix.empty();
    if (node.has_matrix) std::copy_n(from.matrix.begin(), 16, node.matrix.getValue());
    if (!from.translation.empty()) std::copy_n(from.translation.begin(), 3, &node.translation[0]);
    if (!from.scale.empty()) std::copy_n(from.scale.begin(), 3, &node.scale[0]);
    if (!from.rotation.empty()) std::copy_n(from.rotation.begin(), 4, node.rotation.begin());
    return node;
}

GltfAnimation convert(const tinygltf::Animation& from) {
    using Interpolation = GltfAnimation::Sampler::Interpolation;
    GltfAnimation animation;
    animation.name = from.name;
    for (const tinygltf::AnimationSampler& s : from.samplers) {
        animation.samplers.push_back({index(s.input), index(s.output),
                                      s.interpolation == "STEP" ? Interpolation::step
                                      : s.interpolation == "CUBICSPLINE"
                                          ? Interpolation::cubic_spline
                                          : Interpolation::linear});
    }
    for (const tinygltf::AnimationChannel& c : from.channels) {
        animation.channels.push_back({index(c.sampler), index(c.target_node), c.target_path});
    }
    return animation;
}

}  // namespace

void parse_model(Document& document) {
    const tinygltf::Model model = parse(document);
    for (const auto& view : model.bufferViews) document.buffer_views.push_back(convert(view));
    for (const auto& accessor : model.accessors) document.accessors.push_back(convert(accessor));
    for (size_t i = 0; i < model.meshes.size(); ++i) {
        document.meshes.push_back(convert(model.meshes[i], document.json["meshes"][i]));
    }
    for (const auto& node : model.nodes) document.nodes.push_back(convert(node));
    for (const auto& skin : model.skins) {
        document.skins.push_back({indices(skin.joints), index(skin.inverseBindMatrices)});
    }
    for (const auto& animation : model.animations) {
        document.animations.push_back(convert(animation));
    }
}

}  // namespace sightline
