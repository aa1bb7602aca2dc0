#include "scene/gltf/checks.h"

#include "scene/gltf/accessor.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace sightline {
namespace {

// Extensions that are read or do not affect rendering.
constexpr std::string_view known_extensions[] = {
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
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

// Zeros take no space in a file, so they have a limit of their own.
constexpr uint64_t max_elements_without_data = uint64_t{1} << 22;

// Whether `count` elements of `size` bytes, `stride` apart, starting at `offset`, end within
// `length`.
bool fits(uint64_t offset, uint64_t count, uint64_t stride, uint64_t size, uint64_t length) {
    if (count == 0) return offset <= length;
    if (offset > length || size > length - offset) return false;
    return count - 1 <= (length - offset - size) / stride;
}

void check_sparse(const Document& document, const GltfAccessor& a, const std::string& place) {
    const GltfAccessor::Sparse& sparse = a.sparse;
    if (sparse.count > a.count) document.fail(place + ".count", "is above the accessor's count");
    const uint64_t index_size = size_of(sparse.indices_type);
    if (!fits(sparse.indices_offset, sparse.count, index_size, index_size,
              document.buffer_views[sparse.indices_view].byte_length))
        document.fail(place + ".indices", "exceeds its buffer view");
    const uint64_t value_size = element_size(a);
    if (!fits(sparse.values_offset, sparse.count, value_size, value_size,
              document.buffer_views[sparse.values_view].byte_length))
        document.fail(place + ".values", "exceeds its buffer view");
}

void check_accessor(const Document& document, const GltfAccessor& a, uint64_t max_elements,
                    const std::string& place) {
    if (a.count > max_elements) {
        document.fail(place + ".count",
                      fmt::format("{} is above the limit of {}", a.count, max_elements));
    }
    if (a.sparse.count > 0) check_sparse(document, a, place + ".sparse");
    if (a.buffer_view == none) {
        if (a.count > max_elements_without_data) {
            document.fail(place + ".count", fmt::format("{} elements without data, above the "
                                                        "limit of {}",
                                                        a.count, max_elements_without_data));
        }
        return;
    }
    const GltfBufferView& view = document.buffer_views[a.buffer_view];
    const uint64_t size = element_size(a), stride = view.byte_stride ? view.byte_stride : size;
    if (stride < size) {
        document.fail(place,
                      fmt::format("elements of {} bytes overlap: byteStride is {}", size, stride));
    }
    if (!fits(a.byte_offset, a.count, stride, size, view.byte_length)) {
        document.fail(place, fmt::format("exceeds its buffer view: {} elements of {} bytes, {} "
                                         "apart from byte {}, do not fit into {} bytes",
                                         a.count, size, stride, a.byte_offset, view.byte_length));
    }
}

// "2.1" → {2, 1}.
std::optional<std::pair<int, int>> parse_version(const std::string& text) {
    int major = 0, minor = 0, end = 0;
    if (std::sscanf(text.c_str(), "%4d.%4d%n", &major, &minor, &end) != 2) return {};
    if (static_cast<size_t>(end) != text.size()) return {};
    return std::pair{major, minor};
}

}  // namespace

void check_version_and_extensions(Document& document) {
    const nlohmann::json& asset = document.json["asset"];
    const auto version = parse_version(asset["version"]);
    if (!version || version->first != 2)
        document.fail("asset.version", asset["version"].dump() + " instead of \"2.0\"");
    if (asset.contains("minVersion")) {
        const auto least = parse_version(asset["minVersion"]);
        if (!least || *least > std::pair{2, 0})
            document.fail("asset.minVersion", asset["minVersion"].dump() + " is above 2.0");
    }
    const auto is_known = [](const std::string& name) {
        return std::ranges::find(known_extensions, name) != std::end(known_extensions);
    };
    const auto names = [&](const char* key) {
        return document.json.value(key, std::vector<std::string>{});
    };
    const auto required = names("extensionsRequired");
    for (size_t i = 0; i < required.size(); ++i) {
        if (is_known(required[i])) continue;
        document.fail(fmt::format("extensionsRequired[{}]", i), required[i] + " is not supported");
    }
    for (const std::string& name : names("extensionsUsed"))
        if (!is_known(name)) document.warn("extensionsUsed", name + " is not supported: ignored");
}

void check_accessors(const Document& document, uint64_t max_elements) {
    for (size_t i = 0; i < document.buffer_views.size(); ++i) {
        const GltfBufferView& view = document.buffer_views[i];
        const uint64_t size = document.buffers[view.buffer].size();
        if (!fits(view.byte_offset, 1, 1, view.byte_length, size)) {
            document.fail(fmt::format("bufferViews[{}]", i),
                          fmt::format("bytes {} + {} exceed its buffer of {} bytes",
                                      view.byte_offset, view.byte_length, size));
        }
    }
    for (size_t i = 0; i < document.accessors.size(); ++i) {
        check_accessor(document, document.accessors[i], max_elements,
                       fmt::format("accessors[{}]", i));
    }
}

void check_tree(Document& document) {
    std::vector<GltfNode>& nodes = document.nodes;
    for (uint32_t i = 0; i < nodes.size(); ++i) {
        for (size_t c = 0; c < nodes[i].children.size(); ++c) {
            GltfNode& child = nodes[nodes[i].children[c]];
            if (child.parent != none) {
                document.fail(fmt::format("nodes[{}].children[{}]", i, c),
                              fmt::format("nodes[{}] already has a parent, nodes[{}]",
                                          nodes[i].children[c], child.parent));
            }
            child.parent = i;
        }
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
    const auto unreached = std::ranges::find(reached, uint8_t{0});
    if (unreached != reached.end()) {
        document.fail(fmt::format("nodes[{}]", unreached - reached.begin()),
                      "is on or below a cycle of the node hierarchy");
    }
}

void check_animations(const Document& document) {
    for (size_t i = 0; i < document.animations.size(); ++i) {
        const GltfAnimation& animation = document.animations[i];
        for (const GltfAnimation::Channel& channel : animation.channels) {
            if (channel.sampler < animation.samplers.size()) continue;
            document.fail(fmt::format("animations[{}].channels", i),
                          fmt::format("sampler {} is out of range: there are {}", channel.sampler,
                                      animation.samplers.size()));
        }
    }
}

}  // namespace sightline
