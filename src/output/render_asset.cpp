#include "output/render_asset.h"

#include "core/error.h"
#include "core/file_clash.h"
#include "core/file_state.h"
#include "core/files.h"
#include "core/hash.h"
#include "core/parallel.h"
#include "image/module.h"
#include "intersect/engines.h"
#include "intersect/timed_intersector.h"
#include "output/camera_choice.h"
#include "output/decisions.h"
#include "output/environment_cache.h"
#include "output/formats.h"
#include "output/ground_choice.h"
#include "output/render_pictures.h"
#include "output/statistics.h"
#include "output/tile_key.h"
#include "render/aov.h"
#include "render/texture_levels.h"
#include "scene/view_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <optional>
#include <thread>
#include <utility>

namespace sightline {
namespace {

using Clock = std::chrono::steady_clock;

bool writes_exr(const OutputOptions& options) {
    return std::ranges::any_of(options.pictures, is_exr);
}

/// Throws OutputIsInput if an output is one of the inputs.
void check_inputs(const RenderCommand& command, std::vector<std::string> inputs) {
    const OutputOptions& output = command.output;
    std::vector<std::string> outputs = files_of(output);
    outputs.insert(outputs.end(), output.destinations.begin(), output.destinations.end());
    check_outputs_are_not_inputs(outputs, inputs);
}

std::shared_ptr<const Environment> load_environment(const std::string& env,
                                                    const RenderCommand& command) {
    static EnvironmentCache cache;
    return cache.get(command.light, env, command.load.images);
}

/// Faults that take away geometry.
constexpr Fault hiding_faults[] = {
    Fault::object,       Fault::list_entry,        Fault::buffer_view, Fault::accessor,
    Fault::node_cycle,   Fault::matrix_not_finite, Fault::shape,       Fault::primitive,
    Fault::draco_stream, Fault::meshopt_stream,
};

/// Throws Error if a scene is empty and a fault has taken something away.
void check_something_is_left(const Scene& scene) {
    if (!scene.instances.empty()) return;
    const auto hides = [](const FoundFault& found) {
        return std::ranges::any_of(hiding_faults,
                                   [&](Fault fault) { return entry_of(fault).key == found.key; });
    };
    const auto first = std::ranges::find_if(scene.faults, hides);
    if (first == scene.faults.end()) return;
    throw Error(fmt::format("{}: {}; the first of {}: {}: {}", scene.path,
                            entry_of(Fault::nothing_to_draw).wrong, scene.fault_count, first->place,
                            first->text));
}

void warn_of_overflow(const RenderCommand& command, const Environment* environment,
                      AssetResult& result) {
    if (!environment || environment->overflowed_texels() == 0) return;
    result.warnings.push_back(fmt::format(
        "{}: infinite light in {} of its pixels: taken for {}, the largest half float",
        command.light.env, environment->overflowed_texels(), Environment::largest_half));
}

/// `trace_seconds`: of all threads.
void split_render_time(double trace_seconds, AssetResult& result) {
    const double all = result.picture.thread_seconds;
    StageTimes& seconds = result.seconds;
    seconds.trace = all > 0 ? seconds.render * std::min(trace_seconds / all, 1.0) : 0;
    seconds.shade = seconds.render - seconds.trace;
}

/// Adds the warnings and the sizes, once the render has ended.
void add_report(const RenderCommand& command, const RenderContext& context, AssetResult& result) {
    const Scene& scene = context.scene;
    result.warnings.insert(result.warnings.begin(), scene.warnings.begin(), scene.warnings.end());
    result.faults = scene.faults;
    result.fault_count = scene.fault_count;
    warn_of_overflow(command, context.environment, result);
    if (!command.settings.aovs.empty() && !writes_exr(command.output))
        result.warnings.emplace_back("--aov: only .exr holds layers, and none is written");
    for (const std::string& warning : context.intersector.warnings())
        result.warnings.push_back(warning);
    const RenderResult& picture = result.picture;
    if (picture.nonfinite_pixels)
        result.warnings.push_back(
            fmt::format("{} pixels are not finite", picture.nonfinite_pixels));
    result.interrupted = picture.tiles_done < picture.tiles;
    result.intersector_bytes = context.intersector.memory();
    result.scene_bytes = scene_memory(scene);
    result.finer_lookups = context.surfaces.finer_lookups() - result.finer_lookups;
    result.bytes.pyramids = context.surfaces.texture_memory();
    for (const Image& image : scene.images) {
        result.bytes.images += image.memory();
        result.bytes.whole_images += image.memory() << 2 * image.level;
    }
    if (result.interrupted || command.run.part) return;
    result.content = content_of(picture);
    if (result.content != PictureContent::something)
        result.warnings.push_back(why_blank(result.content, context, picture));
}

/// The camera sees the light of an environment's file, but neither that of a built-in light, where
/// it would see lamps, nor the darkness around a file's own lamps.
void choose_background(const RenderCommand& command, const Scene& scene, RenderSettings& settings) {
    const LightOptions& light = command.light;
    const std::string env = choose_environment(light, scene);
    settings.background_color =
        light.background ? light.background_color : scene.background.value_or(default_backdrop);
    const bool seen = is_environment_file(env);
    settings.background = light.background.value_or(
        scene.background || !seen || command.ground.kind == GroundKind::cyclorama
            ? Background::color
            : Background::environment);
    if (settings.background != Background::color) settings.background_color = Vec3(0, 0, 0);
    if (settings.background == Background::environment) settings.background_blur = light.env_blur;
}

/// Whether a picture for a display is made.
bool writes_displayed(const OutputOptions& output) {
    return output.preview || !std::ranges::all_of(output.pictures, is_exr);
}

/// Whether a picture for a display shows colours that are not to be tone mapped.
bool shows_colors(const RenderCommand& command, const Scene& scene,
                  const RenderSettings& settings) {
    const OutputOptions& output = command.output;
    if (output.tone_map == ToneMap::linear && output.exposure == 0 && !output.color_view.is_set())
        return false;
    if (!writes_displayed(output)) return false;
    return settings.background == Background::color ||
           std::ranges::any_of(scene.materials, &Material::unlit);
}

/// Adds the layers that pictures for a display are made from.
void add_display_layers(const RenderCommand& command, const Scene& scene,
                        RenderSettings& settings) {
    if (shows_colors(command, scene, settings)) settings.aovs.insert(shown_layer);
    if (settings.background == Background::transparent &&
        settings.ground.kind == GroundKind::shadow && writes_displayed(command.output))
        settings.aovs.insert(through_layer);
}

void choose_layers(const RenderCommand& command, const Scene& scene, RenderSettings& settings) {
    if (writes_exr(command.output)) {
        settings.cutoff = 0x1p-12f;  // half a quantum of an EXR's half floats around white
        if (settings.aovs.empty()) settings.aovs.insert(aov_names, aov_names + default_aovs);
        settings.aovs.erase("beauty");  // every EXR has it
    } else {
        settings.half = false;
        settings.aovs.clear();
    }
    settings.aovs.merge(needed_layers(command.output.data));
    add_display_layers(command, scene, settings);
}

/// The picture's needs, after the decisions in `report`. The settings are complete.
Needs needs_of(const RenderCommand& command, const Scene& scene, const Environment* environment,
               std::span<const Decision> report) {
    Needs needs = find_needs(scene, command.settings, environment != nullptr);
    needs.report.insert(needs.report.begin(), report.begin(), report.end());
    needs.embree.isa = command.engine.isa;
    needs.embree.threads = command.run.threads;
    return needs;
}

/// The diameter of a lens of focal length f is f / N; before film of 24 mm in height, f is what
/// gives the field of view. In world units, which glTF says are metres.
float aperture_of(float f_stop, float yfov) { return 0.012f / std::tan(yfov / 2) / f_stop; }

}  // namespace

void check_outputs(const RenderCommand& command) {
    for (const std::string& picture : command.output.pictures) check_output(picture);
    for (const std::string& file : files_of(command.output)) check_place(file);
    check_inputs(command, {command.asset, command.light.env});
    if (writes_displayed(command.output)) find_color_view(command.output.color_view);
}

RenderSettings complete_settings(const RenderCommand& command, const Scene& scene,
                                 std::vector<Decision>* report) {
    RenderSettings settings = command.settings;
    const CameraChoice choice = choose_camera(command, scene);
    settings.camera = choice.camera;
    if (report) {
        report->push_back({"camera", choice.name, choice.because, ""});
        report->push_back(light_decision(command.light, scene));
    }
    if (command.view.f_stop && !choice.camera.orthographic)
        settings.aperture = aperture_of(*command.view.f_stop, choice.camera.yfov);
    settings.aperture *= static_cast<float>(scene.frame.scale);
    settings.focus *= static_cast<float>(scene.frame.scale);
    if (settings.integrator == Integrator::appel) {
        settings.samples = 1;
        settings.error = 0;
    }
    choose_background(command, scene, settings);
    settings.ground = choose_ground(command, scene, settings.background_color);
    if (report && settings.ground.kind != GroundKind::nothing)
        report->push_back(ground_decision(command.ground, settings.ground, scene));
    choose_layers(command, scene, settings);
    return settings;
}

struct Asset::State {
    struct Engine {
        std::string name;
        EmbreeOptions options;
        std::unique_ptr<Intersector> intersector;
    };

    Pictures pictures;
    std::string key;            // of what is loaded
    std::optional<float> time;  // to which the scene is posed
    bool is_whole = false;      // false while it is read or posed, and if that has failed
    std::vector<SourceFile> inputs;
    std::vector<std::optional<FileState>> files;  // by input, once all was read
    bool is_settled = true;                       // a change of a file would show in its state
    GltfAsset gltf;
    std::string environment_name;
    std::shared_ptr<const Environment> environment;  // or nullptr
    std::optional<TextureLevels> levels;
    std::vector<WantedLevel> decoded;
    std::shared_ptr<const Surfaces> textures;
    std::shared_ptr<const SharedSurfaces> surfaces;
    std::shared_ptr<const SharedBackdrop> backdrop;
    std::optional<Engine> engine;
    StageTimes seconds;  // of loading, until a result reports them
    StageBytes bytes;

    void load(const RenderCommand& command);
    void pose(const RenderCommand& command);
    void light(const RenderCommand& command);
    void decode(const RenderSettings& settings);
    void build(const RenderCommand& command, const Needs& needs);
    void prepare(const RenderCommand& command, const Needs& needs);
    void add_input(size_t at, const SourceFile& input, int64_t begin);
    void add_scene_files(int64_t begin);
};

namespace {

/// What a loaded asset depends on beside the files and, if it can be posed, the time.
std::string loading_key(const RenderCommand& command, Asset::Pictures pictures) {
    LoadOptions load = command.load;
    if (load.time && pictures == Asset::Pictures::several) load.time = 0.0f;
    return fmt::format("{:016x}:{}:{}:{}:{}", load_options_key(load), command.asset,
                       command.light.env_rotation, command.light.env_brightness, command.light.env);
}

}  // namespace

// Adds a file that has been read since `begin`. One that may have changed meanwhile is read again
// the next time.
void Asset::State::add_input(size_t at, const SourceFile& input, int64_t begin) {
    const std::optional<FileState> file = state_of_file(input.path);
    is_settled &= file && sightline::is_settled(*file, begin);
    if (file) bytes.files += file->size;
    const auto place = static_cast<std::ptrdiff_t>(at);
    inputs.insert(inputs.begin() + place, input);
    files.insert(files.begin() + place, file);
}

// Adds the files of the scene that are not among the inputs, before the environment.
void Asset::State::add_scene_files(int64_t begin) {
    const std::vector<SourceFile>& all = gltf.scene.files;
    const bool has_environment = !inputs.empty() && is_environment_file(environment_name);
    for (size_t i = inputs.size() - has_environment; i < all.size(); ++i)
        add_input(i, all[i], begin);
}

// Reads the asset and, in parallel, the environment.
void Asset::State::load(const RenderCommand& command) {
    key = loading_key(command, pictures);
    time = command.load.time;
    const int64_t start = nanoseconds_now();
    const std::string& named_env = command.light.env;
    // Hashed before it is read: if it changes in between, the hash will not match again.
    std::optional<SourceFile> env_file;
    if (is_environment_file(named_env))
        env_file = {named_env, hash_environment(named_env, command.load.images)};
    std::future<std::shared_ptr<const Environment>> early;
    if (!named_env.empty() && named_env != "none")
        early = std::async(std::launch::async, load_environment, named_env, std::cref(command));
    const auto begin = Clock::now();
    const auto times = pictures == Pictures::several ? GltfFile::Times::any : GltfFile::Times::one;
    run_with_threads(command.run.threads,
                     [&] { gltf = read_gltf(command.asset, command.load, times); });
    check_something_is_left(gltf.scene);
    levels.emplace(gltf.scene, gltf.file->image_sizes());
    seconds.open = gltf.open_seconds;
    seconds.parse = seconds_since(begin) - seconds.open;
    const auto rest = Clock::now();
    add_scene_files(start);
    if (early.valid()) {
        environment = early.get();
        environment_name = named_env;
        if (env_file) add_input(inputs.size(), *env_file, start);
    }
    light(command);
    seconds.decode = seconds_since(rest);
    is_whole = true;
}

// Takes the asset to the command's time.
void Asset::State::pose(const RenderCommand& command) {
    if (command.load.time == time) return;
    const auto begin = Clock::now();
    const int64_t start = nanoseconds_now();
    is_whole = false;
    GltfFile::Change change;
    run_with_threads(command.run.threads,
                     [&] { change = gltf.file->pose(*command.load.time, gltf.scene); });
    time = command.load.time;
    if (change.geometry) {
        engine.reset();
        backdrop.reset();
    }
    if (change.textures) textures.reset();
    if (change.geometry || change.textures) {
        surfaces.reset();
        levels.emplace(gltf.scene, gltf.file->image_sizes());
    }
    add_scene_files(start);
    is_whole = true;
    check_something_is_left(gltf.scene);
    light(command);
    seconds.pose = seconds_since(begin);
}

// Reads the environment that the scene gets, unless that is the one that it has.
void Asset::State::light(const RenderCommand& command) {
    const std::string env = choose_environment(command.light, gltf.scene);
    if (env == environment_name) return;
    backdrop.reset();
    environment = env == "none" ? nullptr : load_environment(env, command);
    environment_name = env;
}

// Decodes the images at the levels that a picture needs, unless they are.
void Asset::State::decode(const RenderSettings& settings) {
    const auto begin = Clock::now();
    std::vector<WantedLevel> wanted =
        levels->wanted(gltf.scene, settings, engine->intersector.get());
    if (textures && wanted == decoded) return;
    surfaces.reset();
    textures.reset();
    gltf.file->decode_images(wanted, gltf.scene);
    decoded = std::move(wanted);
    if (pictures == Pictures::one) gltf.file.reset();
    seconds.decode += seconds_since(begin);
}

// Builds the engine that the needs ask for, unless it exists.
void Asset::State::build(const RenderCommand& command, const Needs& needs) {
    const std::string& asked = command.engine.intersector;
    const std::string name = asked == "auto" ? engine_name(needs) : asked;
    const auto begin = Clock::now();
    EmbreeOptions options = needs.embree;
    options.threads = 0;  // which changes no answer
    if (!engine || engine->name != name || engine->options != options) {
        engine.reset();
        engine = {name, options, make_engine(gltf.scene, name, needs.embree)};
    }
    seconds.build = seconds_since(begin);
}

// Derives what pictures share: of textures, of emitters and of what stands behind and below the
// scene. What exists and serves stays.
void Asset::State::prepare(const RenderCommand& command, const Needs& needs) {
    const unsigned threads = command.run.threads;
    if (!textures) textures = std::make_shared<Surfaces>(gltf.scene, needs.mipmaps, threads);
    if (!surfaces) surfaces = std::make_shared<SharedSurfaces>(gltf.scene, textures, threads);
    if (backdrop && backdrop->serves(command.settings)) return;
    backdrop.reset();
    backdrop = std::make_shared<SharedBackdrop>(gltf.scene, command.settings, environment.get());
}

Asset::Asset(const RenderCommand& command, Pictures pictures) : state_(std::make_unique<State>()) {
    state_->pictures = pictures;
    const auto loading = Clock::now();
    state_->load(command);
    state_->seconds.total = seconds_since(loading);
}

Asset::~Asset() = default;

bool Asset::serves(const RenderCommand& command) const {
    return has_loaded(command) && state_->is_settled &&
           std::ranges::equal(state_->inputs, state_->files, {},
                              [](const SourceFile& input) { return state_of_file(input.path); });
}

bool Asset::has_loaded(const RenderCommand& command) const {
    return state_->is_whole && state_->key == loading_key(command, state_->pictures);
}

const std::vector<SourceFile>& Asset::inputs() const { return state_->inputs; }

const Scene& Asset::scene() const { return state_->gltf.scene; }

void Asset::check_camera(const RenderCommand& command) const {
    const std::string& camera = command.view.camera;
    if (!camera.empty() && !find_view(camera)) choose_camera(command, state_->gltf.scene);
}

AssetResult Asset::render(const RenderCommand& command, std::stop_token stop) {
    return render_unwritten(command, std::move(stop)).write();
}

RenderedPicture Asset::render_unwritten(const RenderCommand& given, std::stop_token stop) {
    AssetResult result;
    const auto begin = Clock::now();
    check_outputs(given);
    const Scene& scene = state_->gltf.scene;
    check_inputs(given, scene.named_files);
    state_->pose(given);
    RenderCommand command = given;
    std::vector<Decision> report;
    command.settings = complete_settings(given, scene, &report);
    const RenderSettings& settings = command.settings;
    const unsigned threads = command.run.threads;
    result.inputs = state_->inputs;
    const Environment* environment = state_->environment.get();
    result.needs = needs_of(command, scene, environment, report);
    state_->build(command, result.needs);
    const uint64_t faults = scene.fault_count;
    state_->decode(settings);
    if (scene.fault_count != faults)  // a lost image has changed materials
        result.needs = needs_of(command, scene, environment, report);
    add_module_need(command, scene, result.needs);
    add_frame_need(scene, result.needs);
    add_texture_need(scene, result.needs);
    const auto prepare = Clock::now();
    state_->prepare(command, result.needs);
    const TimedIntersector intersector(*state_->engine->intersector);
    const RenderContext context(scene, settings, result.needs, intersector, environment,
                                state_->surfaces, state_->backdrop);
    result.needs.report.push_back(context.single_sided.decision);
    result.finer_lookups = context.surfaces.finer_lookups();  // of the pictures before
    result.seconds = std::exchange(state_->seconds, {});
    result.bytes = std::exchange(state_->bytes, {});
    result.seconds.prepare += seconds_since(prepare);

    // Not earlier: while a library is loaded, other threads cannot start.
    if (std::ranges::any_of(command.output.pictures, is_written_by_module)) preload_image_module();
    const auto render_begin = Clock::now();
    result.pose = pose_of(context);
    const double traced_before = intersector.thread_seconds();
    result.intersector = intersector.description();
    result.threads = threads ? threads : std::thread::hardware_concurrency();
    std::unique_ptr<OutputSet> unwritten = render_pictures(
        command, context,
        {.threads = threads,
         .record_rays = command.output.keep_rays || !command.output.record_rays.empty(),
         .show_progress = command.run.show_progress,
         .name = command.run.name,
         .stop = std::move(stop)},
        result);
    result.seconds.render = seconds_since(render_begin) - result.seconds.write;
    split_render_time(intersector.thread_seconds() - traced_before, result);
    add_report(given, context, result);
    result.seconds.total += seconds_since(begin);
    return {std::move(result), std::move(unwritten)};
}

AssetResult render_asset(const RenderCommand& command, std::stop_token stop) {
    check_outputs(command);
    return Asset(command, Asset::Pictures::one).render(command, std::move(stop));
}

}  // namespace sightline
