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

#include <new>

namespace sightline {
namespace {

using nlohmann::json;

bool is_meshopt_fallback(const json& buffer) {
    const json* extension = find_extension(buffer, "EXT_meshopt_compression");
    return extension && extension->is_object() && extension->value("fallback", json()) == true;
}

void load_buffers(Document& document, std::optional<std::span<const std::byte>> bin,
                  const LoadOptions& options) {
    const json& buffers = document.list("buffers");
    for (size_t i = 0; i < buffers.size(); ++i) {
        const json& buffer = buffers[i];
        const std::string place = fmt::format("buffers[{}]", i);
        const auto length = buffer["byteLength"].get<uint64_t>();
        std::span<const std::byte>& bytes = document.buffers.emplace_back();
        if (buffer.contains("uri")) {
            document.storage.push_back(read_uri(document, buffer["uri"], place + ".uri", options));
            bytes = document.storage.back();
        } else if (i == 0 && bin) {
            bytes = *bin;
        } else if (is_meshopt_fallback(buffer)) {
            continue;
        } else {
            document.fail(place, "has no uri, and there is no binary chunk for it");
        }
        if (bytes.size() < length) {
            document.fail(place + ".byteLength",
                          fmt::format("is {}, but there are {} bytes", length, bytes.size()));
        }
        bytes = bytes.first(length);
    }
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
    for (const std::string& line : container.warnings) document.warnings.add(line);
    document.json = parse_json(container.json, path);
    check_structure(document);
    // Loading the module often takes as long as reading the meshes.
    if (options.decode_images && !document.list("textures").empty()) preload_image_module();
    check_version_and_extensions(document);
    parse_model(document);
    load_buffers(document, container.bin, options);
    decode_meshopt(document);
    decode_draco(document, options.max_elements);
    check_accessors(document, options.max_elements);
    check_tree(document);
    check_animations(document);
    return document;
}

}  // namespace

Scene load_gltf(const std::string& path, const LoadOptions& options) try {
    Document document = load_document(path, options);
    const Placement placement = place_scene(document, options);
    if (options.time || !options.animation.empty())
        animate(document, options.animation.empty() ? "all" : options.animation,
                double(options.time.value_or(0)));
    Scene scene = build_scene(document, options, placement);
    scene.named_files = named_files(document);
    return scene;
} catch (const std::bad_alloc&) {
    throw Error(path + ": not enough memory to load it");
}

}  // namespace sightline
