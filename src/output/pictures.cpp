#include "output/pictures.h"

#include "core/hash.h"
#include "render/layers.h"

#include <fmt/format.h>

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

}  // namespace

PictureInfo make_info(const AssetOptions& options, const Scene& scene, const CameraRays& camera,
                      const std::string& engine) {
    PictureInfo info;
    info.world_to_camera = camera.world_to_camera();
    info.world_to_ndc = camera.world_to_ndc();
    info.strings = {
        {"software", "Sightline " SIGHTLINE_VERSION},
        {"comments", options.command},
        {"sightline:asset", scene.path},
        {"sightline:sceneHash", fmt::format("{:016x}", scene.content_hash)},
        {"sightline:intersector", engine},
    };
    return info;
}

Pictures::Pictures(const AssetOptions& options, const RenderJob& job, PictureInfo info)
    : info_(std::move(info)) {
    const unsigned threads =
        options.threads ? options.threads : std::thread::hardware_concurrency();
    const WriteSettings settings{{parse_tone_map(options.tone_map), options.exposure,
                                  job.background == Background::transparent},
                                 {.threads = threads}};
    Film layout = make_film(job, {});
    layout.window = window_of(job);
    add_numbers({}, info_);
    for (const std::string& output : options.outputs)
        writers_.push_back(make_picture_writer(output, layout, info_, settings));
    if (options.preview) {
        DisplaySettings opaque = settings.display;
        opaque.alpha = false;
        preview_.emplace(opaque);
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

uint64_t tile_key(const AssetOptions& o, const RenderJob& job,
                  const std::vector<SourceFile>& inputs, const std::string& engine) {
    std::string text = SIGHTLINE_VERSION "\n" + engine + "\n";
    const auto add = [&](const auto&... values) { ((text += fmt::format("{}\n", values)), ...); };
    const auto add_floats = [&](const float* values, int count) {
        for (int i = 0; i < count; ++i) add(values[i]);
    };
    for (const SourceFile& input : inputs) add(input.hash);
    add(o.load.scene, o.load.variant, o.load.animation,
        o.load.time ? fmt::format("{}", *o.load.time) : "", o.load.allow_outside,
        o.load.images.max_pixels, o.load.max_elements, o.env, o.env_rotation, o.isa, o.intersector,
        o.force_all);
    const Camera& camera = job.camera;
    add_floats(camera.to_world.getValue(), 16);
    add(camera.orthographic, camera.yfov, camera.aspect, camera.xmag, camera.ymag, camera.znear,
        camera.zfar);
    add(job.width, job.height, job.aperture, job.focus, static_cast<int>(job.integrator), job.depth,
        job.samples, job.error, job.max_samples, job.seed, static_cast<int>(job.background),
        job.cutoff);
    add_floats(&job.background_color.x, 3);
    for (const std::string& aov : job.aovs) add(aov);
    return hash_text(text);
}

}  // namespace sightline
