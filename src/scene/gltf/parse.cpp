// The only file that includes tinygltf. It parses buffer views, accessors, nodes, meshes, skins and
// animations, and receives a text with these alone: with images, it would take the address of their
// first byte in a buffer without a bounds check, so it would have to load all buffers and their
// URIs itself before our checks. A section's text is the file's own, unless tinygltf (2.7 and
// later) would not do with it what we want. Then it is written from the JSON that check_structure
// has accepted:
// - if that has mended or replaced something: integers written as 3.0 are ignored,
// - if primitives have indices without a buffer view, as sparse and Draco-compressed ones may:
//   those are refused, and
// - if there are extensions or extras, which would be copied, of any size, into trees of its own.
// It also truncates integers to 32 bits without an error; the rules keep those read as int smaller.
#include "scene/gltf/parse.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <map>
#include <string>

namespace sightline {
namespace {

using nlohmann::json;

// Appends the text of `value` without extensions, extras and, in a primitive, indices.
void write_core(const json& value, bool in_primitive, std::string& text) {
    if (value.is_array() && !value.empty() && value.front().is_structured()) {
        text += '[';
        for (const json& item : value) {
            if (text.back() != '[') text += ',';
            write_core(item, in_primitive, text);
        }
        text += ']';
    } else if (value.is_object()) {
        text += '{';
        for (const auto& [key, item] : value.items()) {
            if (key == "extensions" || key == "extras" || (in_primitive && key == "indices"))
                continue;
            if (text.back() != '{') text += ',';
            text += json(key).dump() + ':';
            write_core(item, key == "primitives", text);
        }
        text += '}';
    } else {
        text += value.dump();
    }
}

using Sections = std::map<std::string_view, std::string_view>;

// The text of the value of each member of a JSON object; of several of one name the last, as
// parsers do. None if a name has an escape, since it may be another's name.
Sections members_of(std::string_view text) {
    Sections members;
    std::string_view name;
    size_t depth = 0, begin = 0;  // of a value; 0 before it
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '"') {
            const size_t first = i + 1;
            for (++i; text[i] != '"'; ++i)
                if (text[i] == '\\') ++i;
            if (depth == 1 && begin == 0) name = text.substr(first, i - first);
            if (name.find('\\') != std::string_view::npos) return {};
        } else if (c == ':' && depth == 1) {
            begin = i + 1;
        } else if ((c == ',' || c == '}') && depth == 1 && begin > 0) {
            members[name] = text.substr(begin, i - begin);
            begin = 0;
        }
        if (c == '{' || c == '[') ++depth;
        if (c == '}' || c == ']') --depth;
    }
    return members;
}

// Whether some primitive's indices have no buffer view.
bool has_indices_without_view(const Document& document) {
    const json& accessors = document.list("accessors");
    for (const json& mesh : document.list("meshes"))
        for (const json& primitive : mesh["primitives"])
            if (const auto at = primitive.find("indices"); at != primitive.end())
                if (!accessors[at->get<size_t>()].contains("bufferView")) return true;
    return false;
}

// What tinygltf parses of a section whose text in the file is `own`, or empty.
std::string section_text(const Document& document, const std::string& name, const json& section,
                         std::string_view own) {
    const auto has = [&](std::string_view word) { return own.find(word) != own.npos; };
    const bool is_good = !own.empty() && !has("\"extensions\"") && !has("\"extras\"") &&
                         !(name == "meshes" && has_indices_without_view(document));
    if (is_good) return std::string(own);
    std::string text;
    write_core(section, false, text);
    return text;
}

tinygltf::Model parse(const Document& document, std::string_view file) {
    const Sections own = members_of(file);
    std::string text = "{";
    for (const char* key :
         {"asset", "bufferViews", "accessors", "meshes", "nodes", "skins", "animations"}) {
        const auto found = document.json.find(key);
        if (found == document.json.end()) continue;
        const auto in_file = own.find(key);
        text += fmt::format("{}\"{}\":", text.size() > 1 ? "," : "", key);
        text += section_text(document, key, *found,
                             in_file == own.end() ? std::string_view() : in_file->second);
    }
    text += '}';
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

// tinygltf uses −1 for `none`.
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
    view.dropped = view.buffer == none;
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

// `source` is the mesh's JSON, from which the indices are read.
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
    for (const tinygltf::AnimationChannel& c : from.channels)
        animation.channels.push_back({index(c.sampler), index(c.target_node), c.target_path});
    return animation;
}

}  // namespace

void parse_model(Document& document, std::string_view text) {
    const tinygltf::Model model = parse(document, text);
    for (const auto& view : model.bufferViews) document.buffer_views.push_back(convert(view));
    for (const auto& accessor : model.accessors) document.accessors.push_back(convert(accessor));
    for (size_t i = 0; i < model.meshes.size(); ++i)
        document.meshes.push_back(convert(model.meshes[i], document.json["meshes"][i]));
    for (const auto& node : model.nodes) document.nodes.push_back(convert(node));
    for (const auto& skin : model.skins)
        document.skins.push_back({indices(skin.joints), index(skin.inverseBindMatrices), {}});
    for (const auto& animation : model.animations)
        document.animations.push_back(convert(animation));
}

}  // namespace sightline
