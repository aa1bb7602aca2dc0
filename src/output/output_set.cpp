#include "output/output_set.h"

#include "core/version.h"
#include "output/formats.h"
#include "render/cryptomatte.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <thread>

namespace sightline {
namespace {

/// Sets the attributes that are known only after the render.
void add_numbers(const RenderResult& picture, PictureMetadata& metadata) {
    const Counters& c = picture.counters;
    const auto set = [&](const char* name, uint64_t value) {
        metadata.numbers[name] = static_cast<double>(value);
    };
    set("sightline:cameraRays", c.rays[0]);
    set("sightline:shadowRays", c.rays[1]);
    set("sightline:reflectionRays", c.rays[2]);
    set("sightline:refractionRays", c.rays[3]);
    set("sightline:samples", c.samples);
    set("sightline:complete", picture.tiles_done == picture.tiles);
}

/// Cryptomatte's metadata for one kind of layer: its name and the manifest of names in it.
void add_cryptomatte(const char* layer, const std::vector<std::string>& names,
                     PictureMetadata& metadata) {
    const auto hex = [](uint32_t hash) { return fmt::format("{:08x}", hash); };
    const std::string place = "cryptomatte/" + hex(murmur3(layer)).substr(0, 7) + "/";
    nlohmann::json manifest = nlohmann::json::object();
    for (const std::string& name : names) manifest[name] = hex(cryptomatte_id(name));
    metadata.strings[place + "name"] = layer;
    metadata.strings[place + "hash"] = "MurmurHash3_32";
    metadata.strings[place + "conversion"] = "uint32_to_float32";
    metadata.strings[place + "manifest"] =
        manifest.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

// The camera's matrices for world units, given those for the scene's.
void set_matrices(const CameraRays& camera, const Frame& frame, PictureMetadata& metadata) {
    const auto scale = static_cast<float>(frame.scale);
    metadata.world_to_camera = camera.world_to_camera();
    metadata.world_to_ndc = camera.world_to_ndc();
    for (int c = 0; c < 4; ++c) {
        if (c < 3) metadata.world_to_camera[3][c] /= scale;
        for (int r = 0; r < 3; ++r) metadata.world_to_ndc[r][c] *= scale;
    }
}

PictureMetadata make_metadata(const std::string& command, const RenderContext& context,
                              const std::string& engine) {
    const Scene& scene = context.scene;
    PictureMetadata metadata;
    set_matrices(context.camera, scene.frame, metadata);
    if (scene.frame.origin != Vec3d(0)) metadata.origin = scene.frame.origin;
    metadata.strings = {
        {"software", std::string("Sightline ") + program_version},
        {"comments", command},
        {"sightline:asset", scene.path},
        {"sightline:sceneHash", fmt::format("{:016x}", scene.content_hash)},
        {"sightline:intersector", engine},
    };
    if (context.settings.aovs.contains("cryptomatte")) {
        add_cryptomatte("CryptoObject", object_names(scene), metadata);
        add_cryptomatte("CryptoMaterial", material_names(scene), metadata);
    }
    return metadata;
}

}  // namespace

std::string partial_path(const std::string& picture) {
    const std::filesystem::path path(picture);
    return path.parent_path() / (path.stem().string() + ".partial" + path.extension().string());
}

OutputSet::OutputSet(const OutputOptions& given, unsigned threads, const RenderContext& context,
                     const std::string& engine)
    : metadata_(make_metadata(given.command, context, engine)) {
    OutputOptions options = given;
    options.exr.threads = threads ? threads : std::thread::hardware_concurrency();
    const bool alpha = context.settings.background == Background::transparent;
    const Film& layout = context.layers.layout;
    add_numbers({}, metadata_);
    // Before the pictures: they may not fit in their files.
    if (!options.data.empty()) paths_ = data_paths(options.pictures.at(0), options.data);
    for (const std::string& name : options.data) {
        auto writer = std::make_unique<DataWriter>(name, layout.window, options.depth_scale, alpha);
        data_.push_back(writer.get());
        writers_.push_back(std::move(writer));
    }
    paths_.insert(paths_.end(), options.pictures.begin(), options.pictures.end());
    for (const std::string& picture : options.pictures)
        writers_.push_back(make_picture_writer(picture, layout, metadata_, options, alpha));
    if (options.preview)
        preview_.emplace(layout.window, [options, view = find_color_view(options.color_view)](
                                            const Film& band) {
            return display_picture(band, {options.tone_map, view.get()}, options.exposure, false);
        });
}

void OutputSet::add(const Film& band) {
    for (const auto& writer : writers_) writer->add(band);
    if (preview_) preview_->add(band);
}

std::map<std::string, DataScale> OutputSet::data_scales() const {
    std::map<std::string, DataScale> scales;
    for (const DataWriter* writer : data_) scales[writer->layer()] = writer->scale();
    return scales;
}

void OutputSet::finish(const RenderResult& result) {
    add_numbers(result, metadata_);
    const bool complete = result.tiles_done == result.tiles;
    for (size_t i = 0; i < writers_.size(); ++i)
        writers_[i]->finish(metadata_, complete ? paths_[i] : partial_path(paths_[i]));
}

}  // namespace sightline
