#include "scene/gltf/load.h"

#include "core/error.h"
#include "core/files.h"
#include "image/module.h"
#include "scene/gltf/all_faults.h"
#include "scene/gltf/build.h"
#include "scene/gltf/checks.h"
#include "scene/gltf/container.h"
#include "scene/gltf/document.h"
#include "scene/gltf/draco.h"
#include "scene/gltf/images.h"
#include "scene/gltf/meshopt.h"
#include "scene/gltf/needed_buffers.h"
#include "scene/gltf/parse.h"
#include "scene/gltf/schema.h"
#include "scene/gltf/uri.h"

#include <fmt/format.h>

#include <chrono>

namespace sightline {
namespace {

using nlohmann::json;

using Bytes = std::span<const std::byte>;

// A buffer's bytes, or nothing and why.
struct BufferRead {
    std::optional<Bytes> bytes;
    std::string place, problem;
};

BufferRead read_buffer(Document& document, size_t index, std::optional<Bytes> bin,
                       const LoadOptions& options) {
    const json& buffer = document.list("buffers")[index];
    const auto length = buffer["byteLength"].get<uint64_t>();
    const std::string place = fmt::format("buffers[{}]", index);
    Bytes bytes;
    if (buffer.contains("uri")) {
        std::string problem;
        auto read = read_uri(document, buffer["uri"], place + ".uri", options, problem);
        if (!read) return {{}, place + ".uri", problem};
        bytes = document.storage.emplace_back(std::move(*read));
    } else if (index == 0 && bin) {
        bytes = *bin;
    } else {
        return {{}, place, "has no uri, and there is no binary chunk for it"};
    }
    if (bytes.size() < length)
        return {{},
                place + ".byteLength",
                fmt::format("is {}, but there are {} bytes", length, bytes.size())};
    return {bytes.first(length), "", ""};
}

// Buffers that nothing needs stay empty. They are not even opened, except to list all faults.
void load_buffers(Document& document, std::optional<Bytes> bin, const LoadOptions& options) {
    const bool animated = options.time || !options.animation.empty() || options.find_all_faults;
    document.needed_buffers = needed_buffers(document, animated);
    document.buffers.resize(document.needed_buffers.size());
    for (size_t i = 0; i < document.buffers.size(); ++i) {
        const bool needed = document.needed_buffers[i];
        if (!needed && !options.find_all_faults) continue;
        const BufferRead read = read_buffer(document, i, bin, options);
        if (!read.bytes)
            document.report(needed ? Fault::buffer : Fault::unneeded_buffer, read.place,
                            read.problem);
        if (needed) document.buffers[i] = *read.bytes;
    }
}

/// Loading OpenImageIO often takes as long as reading the meshes. PNG and JPEG do not need it.
void preload_image_decoder(const Document& document) {
    for (const json& name : document.list("extensionsUsed"))
        if (name == "EXT_texture_webp" || name == "EXT_texture_avif") preload_image_module();
}

/// Reads, checks and parses a file and its buffers; meshopt and Draco data become plain buffer
/// views and accessors. Throws Error.
void load_document(Document& document, const LoadOptions& options) {
    const std::string& path = document.path;
    const GltfContainer container = split_container(document.storage.back(), path);
    for (const auto& [fault, place, detail] : container.faults)
        document.report(fault, place, detail);
    document.json = parse_json(container.json, path);
    check_version(document);
    const bool is_unchanged = check_structure(document);
    if (options.decode_images) preload_image_decoder(document);
    check_minimum_version(document);
    check_extensions(document);
    parse_model(document, is_unchanged ? container.json : std::string_view());
    load_buffers(document, container.bin, options);
    decode_meshopt(document);
    decode_draco(document, options.max_elements);
    check_accessors(document, options.max_elements);
    check_tree(document);
    check_skins(document);
    check_animations(document);
}

FileBytes read_asset(const std::string& path, uint64_t max_bytes) {
    if (path != standard_input) return read_file(path, max_bytes);
    static const FileBytes kept = read_standard_input(max_bytes);
    return kept;
}

}  // namespace

std::string asset_label(const std::string& path) {
    return path == standard_input ? standard_input_name : path;
}

GltfFile::GltfFile(std::unique_ptr<Document> document, const LoadOptions& options, Times times,
                   Scene& scene)
    : options_(options), document_(std::move(document)) {
    const bool several = times == Times::any && options_.time && !document_->animations.empty();
    std::vector<GltfNode> rest;
    if (options_.find_all_faults) rest = document_->nodes;
    poser_ = std::make_unique<ScenePoser>(*document_, options_, several);
    poser_->pose(options_.time, scene);
    scene.named_files = named_files(*document_);
    if (options_.find_all_faults) {
        document_->nodes = std::move(rest);
        report_all_faults(*document_, options_);
    }
    images_ = std::make_unique<GltfImages>(*document_, options_);
    images_->choose(*poser_, scene);
    if (!several) images_->free_buffers();
}

GltfFile::~GltfFile() = default;

std::vector<std::array<int, 2>> GltfFile::image_sizes() const { return images_->sizes(); }

void GltfFile::decode_images(std::span<const WantedLevel> wanted, Scene& scene) {
    images_->decode(wanted, scene);
}

GltfFile::Change GltfFile::pose(float time, Scene& scene) {
    if (document_->animations.empty()) return {};
    Change change;
    change.geometry = poser_->pose(time, scene);
    change.textures = images_->choose(*poser_, scene);
    return change;
}

GltfAsset read_gltf(const std::string& path, const LoadOptions& options, GltfFile::Times times) {
    GltfAsset asset;
    auto document = std::make_unique<Document>();
    document->path = asset_label(path);
    document->has_folder = path != standard_input;
    document->strict = options.strict;
    document->budget.values = options.max_accessor_values;
    const auto begin = std::chrono::steady_clock::now();
    document->storage.push_back(read_asset(path, options.max_file_bytes));
    document->add_file(document->path, document->storage.back());
    asset.open_seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    load_document(*document, options);
    asset.file = std::make_unique<GltfFile>(std::move(document), options, times, asset.scene);
    return asset;
}

Scene load_gltf(const std::string& path, const LoadOptions& options) {
    GltfAsset asset = read_gltf(path, options);
    if (options.decode_images) asset.file->decode_images({}, asset.scene);
    return std::move(asset.scene);
}

}  // namespace sightline
