#include "scene/gltf/load.h"

#include "core/error.h"
#include "core/files.h"
#include "image/module.h"
#include "scene/gltf/animation.h"
#include "scene/gltf/build.h"
#include "scene/gltf/checks.h"
#include "scene/gltf/container.h"
#include "scene/gltf/draco.h"
#include "scene/gltf/meshopt.h"
#include "scene/gltf/parse.h"
#include "scene/gltf/placement.h"
#include "scene/gltf/schema.h"
#include "scene/gltf/uri.h"

#include <fmt/format.h>

namespace sightline {
namespace {

using nlohmann::json;

// Whether a view without meshopt compression, which has its own buffer, needs the buffer's bytes.
std::vector<bool> needed_buffers(const Document& document) {
    std::vector<bool> needed(document.list("buffers").size(), false);
    for (size_t i = 0; i < document.buffer_views.size(); ++i)
        if (!document.buffer_views[i].dropped && !find_meshopt(document.json["bufferViews"][i]))
            needed[document.buffer_views[i].buffer] = true;
    return needed;
}

void load_buffers(Document& document, std::optional<std::span<const std::byte>> bin,
                  const LoadOptions& options) {
    const std::vector<bool> needed = needed_buffers(document);
    const json& buffers = document.list("buffers");
    for (size_t i = 0; i < buffers.size(); ++i) {
        const json& buffer = buffers[i];
        const std::string place = fmt::format("buffers[{}]", i);
        const auto length = buffer["byteLength"].get<uint64_t>();
        std::span<const std::byte>& bytes = document.buffers.emplace_back();
        if (buffer.contains("uri")) {
            std::string problem;
            auto read = read_uri(document, buffer["uri"], place + ".uri", options, problem);
            if (!read) document.report(Fault::buffer, place + ".uri", problem);
            bytes = document.storage.emplace_back(std::move(*read));
        } else if (i == 0 && bin) {
            bytes = *bin;
        } else if (!needed[i]) {
            continue;  // a placeholder, such as meshopt compression leaves for what it replaces
        } else {
            document.report(Fault::buffer, place,
                            "has no uri, and there is no binary chunk for it");
        }
        if (bytes.size() < length) {
            document.report(Fault::buffer, place + ".byteLength",
                            fmt::format("is {}, but there are {} bytes", length, bytes.size()));
        }
        bytes = bytes.first(length);
    }
}

/// Loading OpenImageIO often takes as long as reading the meshes. PNG and JPEG do not need it.
void preload_image_decoder(const Document& document) {
    for (const json& name : document.list("extensionsUsed"))
        if (name == "EXT_texture_webp" || name == "EXT_texture_avif") preload_image_module();
}

/// Reads, checks and parses a file and its buffers; meshopt and Draco data become plain buffer
/// views and accessors. Throws Error.
Document load_document(const std::string& path, const LoadOptions& options) {
    Document document;
    document.path = path;
    document.strict = options.strict;
    document.budget.values = options.max_accessor_values;
    document.storage.push_back(read_file(path, options.max_file_bytes));
    document.add_file(path, document.storage.back());
    const GltfContainer container = split_container(document.storage.back(), path);
    for (const auto& [fault, place, detail] : container.faults)
        document.report(fault, place, detail);
    document.json = parse_json(container.json, path);
    check_version(document);
    check_structure(document);
    if (options.decode_images) preload_image_decoder(document);
    check_minimum_version(document);
    check_extensions(document);
    parse_model(document);
    load_buffers(document, container.bin, options);
    decode_meshopt(document);
    decode_draco(document, options.max_elements);
    check_accessors(document, options.max_elements);
    check_tree(document);
    check_skins(document);
    check_animations(document);
    return document;
}

}  // namespace

Scene load_gltf(const std::string& path, const LoadOptions& options) {
    Document document = load_document(path, options);
    const Placement placement = place_scene(document, options);
    if (options.time || !options.animation.empty())
        animate(document, options.animation, double(options.time.value_or(0)));
    Scene scene = build_scene(document, options, placement);
    scene.named_files = named_files(document);
    return scene;
}

}  // namespace sightline
