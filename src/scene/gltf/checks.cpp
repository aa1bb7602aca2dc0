#include "scene/gltf/checks.h"

#include "scene/gltf/accessor.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace sightline {
namespace {

// Extensions that are read or do not affect rendering.
constexpr std::string_view known_extensions[] = {
    "EXT_lights_image_based",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_gaussian_splatting",
    "KHR_implicit_shapes",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_meshopt_compression",
    "KHR_mesh_quantization",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "SIGHTLINE_background",
    "SIGHTLINE_implicit_shapes",
};

// Beginnings of the names of extensions without which geometry and bytes stay what they are.
constexpr std::string_view extensions_of_looks[] = {
    "ADOBE_materials_",
    "AGI_",
    "EXT_instance_features",
    "EXT_lights_",
    "EXT_materials_",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "EXT_texture_",
    "GOOGLE_texture_",
    "GODOT_",
    "KHR_animation_pointer",
    "KHR_audio",
    "KHR_interactivity",
    "KHR_lights_",
    "KHR_materials_",
    "KHR_node_",
    "KHR_physics_",
    "KHR_texture_",
    "MSFT_audio",
    "MSFT_packing_",
    "MSFT_physics",
    "MSFT_texture_",
    "NV_materials_",
    "OMI_",
    "VRMC_",
};

// Zeros take no space in a file, so they have a limit of their own.
constexpr uint64_t max_elements_without_data = uint64_t{1} << 22;

// Whether `count` elements of `size` bytes, `stride` apart, starting at `offset`, end within
// `length`.
bool fits(uint64_t offset, uint64_t count, uint64_t stride, uint64_t size, uint64_t length) {
    if (count == 0) return offset <= length;
    if (offset > length || size > length - offset) return false;
    return count - 1 <= (length - offset - size) / stride;
}

std::string sparse_problem(const Document& document, const GltfAccessor& a) {
    const GltfAccessor::Sparse& sparse = a.sparse;
    if (sparse.count > a.count) return ".sparse.count: is above the accessor's count";
    const uint64_t index_size = size_of(sparse.indices_type);
    if (!fits(sparse.indices_offset, sparse.count, index_size, index_size,
              document.buffer_views[sparse.indices_view].byte_length))
        return ".sparse.indices: exceeds its buffer view";
    const uint64_t value_size = element_size(a);
    if (!fits(sparse.values_offset, sparse.count, value_size, value_size,
              document.buffer_views[sparse.values_view].byte_length))
        return ".sparse.values: exceeds its buffer view";
    return {};
}

// What is wrong with an accessor: "PROPERTY: reason", where the property may be none. Empty if
// nothing is.
std::string accessor_problem(const Document& document, const GltfAccessor& a) {
    if (a.sparse.count > 0) {
        std::string problem = sparse_problem(document, a);
        if (!problem.empty()) return problem;
    }
    if (a.buffer_view == none) return {};
    const GltfBufferView& view = document.buffer_views[a.buffer_view];
    if (view.dropped) return fmt::format(": bufferViews[{}] is left out", a.buffer_view);
    const uint64_t size = element_size(a), stride = view.byte_stride ? view.byte_stride : size;
    if (stride < size)
        return fmt::format(": elements of {} bytes overlap: byteStride is {}", size, stride);
    if (fits(a.byte_offset, a.count, stride, size, view.byte_length)) return {};
    return fmt::format(
        ": exceeds its buffer view: {} elements of {} bytes, {} apart from byte {}, do not fit "
        "into {} bytes",
        a.count, size, stride, a.byte_offset, view.byte_length);
}

void check_limits(const Document& document, const GltfAccessor& a, uint64_t max_elements,
                  const std::string& place) {
    if (a.count > max_elements)
        document.fail(place + ".count",
                      fmt::format("{} is above the limit of {}", a.count, max_elements));
    if (a.buffer_view == none && a.count > max_elements_without_data)
        document.fail(place + ".count", fmt::format("{} elements without data, above the limit of "
                                                    "{}",
                                                    a.count, max_elements_without_data));
}

// Empties a view.
void drop(Document& document, GltfBufferView& view) {
    view = {};
    view.buffer = static_cast<uint32_t>(document.buffers.size() - 1);
    view.dropped = true;
}

bool is_unread(const Document& document, uint32_t buffer) {
    return buffer < document.needed_buffers.size() && !document.needed_buffers[buffer];
}

// The size of a buffer, also of one that is not read.
uint64_t size_of_buffer(const Document& document, uint32_t buffer) {
    if (!is_unread(document, buffer)) return document.buffers[buffer].size();
    return document.list("buffers")[buffer]["byteLength"];
}

void check_buffer_views(Document& document) {
    document.buffers.emplace_back();  // of the views that are left out
    for (size_t i = 0; i < document.buffer_views.size(); ++i) {
        GltfBufferView& view = document.buffer_views[i];
        if (!view.dropped) {
            const uint64_t size = size_of_buffer(document, view.buffer);
            if (fits(view.byte_offset, 1, 1, view.byte_length, size)) continue;
            document.report(Fault::buffer_view, fmt::format("bufferViews[{}]", i),
                            fmt::format("bytes {} + {} exceed its buffer of {} bytes",
                                        view.byte_offset, view.byte_length, size));
        }
        drop(document, view);
    }
}

// Empties, without a report, what lies in buffers that are not read.
void drop_unread(Document& document) {
    for (GltfBufferView& view : document.buffer_views)
        if (is_unread(document, view.buffer)) drop(document, view);
    const auto is_dropped = [&](uint32_t view) {
        return view != none && document.buffer_views[view].dropped;
    };
    for (GltfAccessor& a : document.accessors) {
        if (!is_dropped(a.buffer_view) && !is_dropped(a.sparse.indices_view) &&
            !is_dropped(a.sparse.values_view))
            continue;
        a = {};
        a.dropped = true;
    }
}

// "2.1" → {2, 1}.
std::optional<std::pair<int, int>> parse_version(const std::string& text) {
    int major = 0, minor = 0, end = 0;
    if (std::sscanf(text.c_str(), "%4d.%4d%n", &major, &minor, &end) != 2) return {};
    if (static_cast<size_t>(end) != text.size()) return {};
    return std::pair{major, minor};
}

// False, with a report, if the skin's matrices cannot be read.
bool read_inverse_binds(Document& document, GltfSkin& skin, const std::string& place) {
    try {
        auto read = read_floats<Mat4>(document, skin.inverse_bind_matrices, Fault::skin, place);
        std::copy_n(read.begin(), skin.joints.size(), skin.inverse_binds.begin());
        return true;
    } catch (const FaultyPart& part) {
        document.report(part);
        return false;
    }
}

}  // namespace

void check_version(Document& document) {
    nlohmann::json& json = document.json;
    const auto found = json.find("asset");
    const bool has_asset = found != json.end() && found->is_object();
    const nlohmann::json version = has_asset ? found->value("version", nlohmann::json()) : nullptr;
    // In glTF 1.0, lists are objects, and the version is optional.
    const bool is_old = version.is_null() && (json.value("meshes", nlohmann::json()).is_object() ||
                                              json.value("nodes", nlohmann::json()).is_object());
    const std::string text = version.is_string() ? version.get<std::string>() : version.dump();
    if (is_old || text == "1" || text.starts_with("1."))
        document.report(Fault::gltf_1, "asset.version",
                        "this is glTF 1.0, but only 2.0 is read; gltf-pipeline converts it: npx "
                        "gltf-pipeline -i FILE -o NEW.gltf");
    if (!has_asset || version.is_null()) document.fail("asset.version", "is missing");
    const auto parsed = parse_version(text);
    if ((parsed && parsed->first > 2) || (!parsed && text != "2"))
        document.report(Fault::minimum_version, "asset.version",
                        version.dump() + " instead of \"2.0\"");
    if (!version.is_string() || !parsed) {
        document.report(Fault::property, "asset.version", text + " is not \"2.0\"");
        (*found)["version"] = "2.0";
    } else if (parsed->second > 0) {
        document.report(Fault::newer_version, "asset.version", version.dump() + " is above 2.0");
    }
}

void check_minimum_version(Document& document) {
    const nlohmann::json& asset = document.json["asset"];
    if (!asset.contains("minVersion")) return;
    const auto least = parse_version(asset["minVersion"]);
    if (!least || *least > std::pair{2, 0})
        document.report(Fault::minimum_version, "asset.minVersion",
                        asset["minVersion"].dump() + " is above 2.0");
}

void check_extensions(Document& document) {
    const auto is_known = [](const std::string& name) {
        return std::ranges::find(known_extensions, name) != std::end(known_extensions);
    };
    const auto changes_looks = [](const std::string& name) {
        return std::ranges::any_of(
            extensions_of_looks, [&](std::string_view prefix) { return name.starts_with(prefix); });
    };
    const auto names = [&](const char* key) {
        return document.json.value(key, std::vector<std::string>{});
    };
    const auto required = names("extensionsRequired");
    for (size_t i = 0; i < required.size(); ++i) {
        if (is_known(required[i])) continue;
        document.report(changes_looks(required[i]) ? Fault::required_extension
                                                   : Fault::required_geometry_extension,
                        fmt::format("extensionsRequired[{}]", i),
                        required[i] + " is not supported");
    }
    for (const std::string& name : names("extensionsUsed"))
        if (!is_known(name))
            document.report(Fault::unknown_extension, "extensionsUsed", name + " is not supported");
    const auto& scenes = document.list("scenes");
    for (size_t i = 0; i < scenes.size(); ++i)
        if (find_extension(scenes[i], "EXT_lights_image_based"))
            document.report(Fault::image_based_light, fmt::format("scenes[{}]", i));
}

void check_accessors(Document& document, uint64_t max_elements) {
    check_buffer_views(document);
    for (size_t i = 0; i < document.accessors.size(); ++i) {
        GltfAccessor& accessor = document.accessors[i];
        const std::string place = fmt::format("accessors[{}]", i);
        const std::string problem = accessor_problem(document, accessor);
        if (problem.empty()) {
            check_limits(document, accessor, max_elements, place);
            continue;
        }
        const size_t colon = problem.find(": ");
        document.report(Fault::accessor, place + problem.substr(0, colon),
                        problem.substr(colon + 2));
        accessor = {};
        accessor.dropped = true;
    }
    drop_unread(document);
}

void check_tree(Document& document) {
    std::vector<GltfNode>& nodes = document.nodes;
    for (uint32_t i = 0; i < nodes.size(); ++i) {
        std::vector<uint32_t> children;
        for (size_t c = 0; c < nodes[i].children.size(); ++c) {
            const uint32_t index = nodes[i].children[c];
            GltfNode& child = nodes[index];
            if (child.parent == none) {
                child.parent = i;
                children.push_back(index);
            } else {
                document.report(
                    Fault::second_parent, fmt::format("nodes[{}].children[{}]", i, c),
                    fmt::format("nodes[{}] already has a parent, nodes[{}]", index, child.parent));
            }
        }
        nodes[i].children = std::move(children);
    }
    // As each node has one parent, the nodes not reachable from a root are those on or below a
    // cycle.
    std::vector<uint8_t> reached(nodes.size(), 0);
    std::vector<uint32_t> open;
    for (uint32_t i = 0; i < nodes.size(); ++i)
        if (nodes[i].parent == none) open.push_back(i);
    while (!open.empty()) {
        const uint32_t node = open.back();
        open.pop_back();
        reached[node] = 1;
        open.insert(open.end(), nodes[node].children.begin(), nodes[node].children.end());
    }
    for (uint32_t i = 0; i < nodes.size(); ++i)
        if (!reached[i])
            document.report(Fault::node_cycle, fmt::format("nodes[{}]", i),
                            "is on or below a cycle of the node hierarchy");
    for (uint32_t i = 0; i < nodes.size(); ++i)
        if (!reached[i]) nodes[i] = {}, document.json["nodes"][i] = nlohmann::json::object();
}

void check_skins(Document& document) {
    std::vector<bool> usable(document.skins.size(), true);
    for (size_t i = 0; i < document.skins.size(); ++i) {
        GltfSkin& skin = document.skins[i];
        const std::string place = fmt::format("skins[{}]", i);
        const auto reject = [&](const char* property, const std::string& reason) {
            document.report(Fault::skin, place + property, reason);
            usable[i] = false;
        };
        if (skin.joints.empty()) reject(".joints", "is empty");
        skin.inverse_binds.resize(skin.joints.size());
        if (skin.inverse_bind_matrices == none) continue;
        const GltfAccessor& a = document.accessors[skin.inverse_bind_matrices];
        if (a.dropped || a.rows != 4 || a.columns != 4)
            reject(".inverseBindMatrices", "is not an accessor of 4 × 4 matrices");
        else if (a.count < skin.joints.size())
            reject(".inverseBindMatrices",
                   fmt::format("has {} matrices for {} joints", a.count, skin.joints.size()));
        else
            usable[i] = read_inverse_binds(document, skin, place + ".inverseBindMatrices");
    }
    for (GltfNode& node : document.nodes)
        if (node.skin != none && !usable[node.skin]) node.skin = none;
}

void check_animations(Document& document) {
    for (size_t i = 0; i < document.animations.size(); ++i) {
        GltfAnimation& animation = document.animations[i];
        for (size_t c = 0; c < animation.channels.size(); ++c) {
            GltfAnimation::Channel& channel = animation.channels[c];
            if (channel.node == none) continue;
            const std::string place = fmt::format("animations[{}].channels[{}]", i, c);
            if (channel.sampler >= animation.samplers.size())
                document.report(Fault::channel, place,
                                fmt::format("sampler {} is out of range: there are {}",
                                            channel.sampler, animation.samplers.size()));
            else if (animation.samplers[channel.sampler].input == none)
                document.report(Fault::channel, place,
                                fmt::format("samplers[{}] is left out", channel.sampler));
            else
                continue;
            channel.node = none;
        }
    }
}

}  // namespace sightline
