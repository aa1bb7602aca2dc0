#include "output/pictures.h"

#include "core/hash.h"
#include "core/version.h"
#include "render/cryptomatte.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <thread>

namespace sightline {
namespace {

/// What is known only when all is rendered.
void add_numbers(const RenderResult& picture, PictureInfo& info) {
    const Counters& c = picture.counters;
    const auto set = [&](const char* name, uint64_t value) {
        info.numbers[name] = static_cast<double>(value);
    };
    set("sightline:cameraRays", c.rays[0]);
    set("sightline:shadowRays", c.rays[1]);
    set("sightline:reflectionRays", c.rays[2]);
    set("sightline:refractionRays", c.rays[3]);
    set("sightline:samples", c.samples);
    set("sightline:complete", picture.tiles_done == picture.tiles);
}

/// The metadata by which Cryptomatte's readers know the layers of one kind and the names in them.
void add_cryptomatte(const char* layer, const std::vector<std::string>& names, PictureInfo& info) {
    const auto hex = [](uint32_t hash) { return fmt::format("{:08x}", hash); };
    const std::string place = "cryptomatte/" + hex(murmur3(layer)).substr(0, 7) + "/";
    nlohmann::json manifest = nlohmann::json::object();
    for (const std::string& name : names) manifest[name] = hex(cryptomatte_id(name));
    info.strings[place + "name"] = layer;
    info.strings[place + "hash"] = "MurmurHash3_32";
    info.strings[place + "conversion"] = "uint32_to_float32";
    info.strings[place + "manifest"] =
        manifest.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace

PictureInfo make_info(const AssetOptions& options, const RenderContext& context,
                      const std::string& engine) {
    const Scene& scene = context.scene;
    PictureInfo info;
    info.world_to_camera = context.camera.world_to_camera();
    info.world_to_ndc = context.camera.world_to_ndc();
    info.strings = {
        {"software", std::string("Sightline ") + program_version},
        {"comments", options.command},
        {"sightline:asset", scene.path},
        {"sightline:sceneHash", fmt::format("{:016x}", scene.content_hash)},
        {"sightline:intersector", engine},
    };
    if (context.settings.aovs.contains("cryptomatte")) {
        add_cryptomatte("CryptoObject", object_names(scene), info);
        add_cryptomatte("CryptoMaterial", material_names(scene), info);
    }
    return info;
}

Pictures::Pictures(const AssetOptions& options, const RenderContext& context,
                   const std::string& engine)
    : info_(make_info(options, context, engine)) {
    WriteSettings settings{{parse_tone_map(options.tone_map), options.exposure,
                            context.settings.background == Background::transparent},
                           options.exr};
    settings.exr.threads = options.threads ? options.threads : std::thread::hardware_concurrency();
    const Film& layout = context.layers.layout;
    add_numbers({}, info_);
    for (const std::string& output : options.outputs)
        writers_.push_back(make_picture_writer(output, layout, info_, settings));
    if (options.preview) {
        DisplaySettings opaque = settings.display;
        opaque.alpha = false;
        preview_.emplace(opaque, layout.window);
    }
}

void Pictures::add(const Film& band) {
    for (const auto& writer : writers_) writer->add(band);
    if (preview_) preview_->add(band);
}

void Pictures::finish(const RenderResult& result) {
    add_numbers(result, info_);
    for (const auto& writer : writers_) writer->finish(info_);
}

uint64_t tile_key(const AssetOptions& o, const RenderSettings& settings,
                  const std::vector<SourceFile>& inputs, const std::string& engine) {
    std::string text = std::string(program_version) + "\n" + engine + "\n";
    const auto add = [&](const auto&... values) { ((text += fmt::format("{}\n", values)), ...); };
    const auto add_floats = [&](const float* values, int count) {
        for (int i = 0; i < count; ++i) add(values[i]);
    };
    for (const SourceFile& input : inputs) add(input.hash);
    add(o.load.scene, o.load.variant, o.load.animation,
        o.load.time ? fmt::format("{}", *o.load.time) : "", o.load.allow_outside,
        o.load.images.max_pixels, o.load.max_elements, o.env, o.env_rotation, o.isa, o.intersector,
        o.force_all);
    const Camera& camera = settings.camera;
    add_floats(camera.to_world.getValue(), 16);
    add(camera.orthographic, camera.yfov, camera.aspect, camera.xmag, camera.ymag, camera.znear,
        camera.zfar);
    add(settings.width, settings.height, settings.aperture, settings.focus,
        static_cast<int>(settings.integrator), settings.depth, settings.samples, settings.error,
        settings.max_samples, settings.seed, static_cast<int>(settings.background),
        settings.cutoff);
    add_floats(&settings.background_color.x, 3);
    for (const std::string& aov : settings.aovs) add(aov);
    return hash_text(text);
}

}  // namespace sightline
