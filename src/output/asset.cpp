#include "output/asset.h"

#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "core/text.h"
#include "image/module.h"
#include "intersect/engines.h"
#include "intersect/ray_file.h"
#include "output/pictures.h"
#include "scene/camera_fit.h"
#include "shade/studio.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <thread>

namespace sightline {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

Camera file_camera(const Scene& scene, const std::string& wanted) {
    std::vector<std::string> names;
    for (const Camera& camera : scene.cameras) names.push_back(camera.name);
    if (const auto found = find_choice(names, wanted)) return scene.cameras[*found];
    throw Error(fmt::format("{}: there is no camera \"{}\"; the file has {}, and there is fit",
                            scene.path, wanted, list_choices(names)));
}

Camera choose_camera(const AssetOptions& options, const Scene& scene) {
    Camera camera;
    if (options.look_from || options.look_at) {
        const Vec3 centre = scene.bounds.isEmpty() ? Vec3(0, 0, 0) : scene.bounds.center();
        camera =
            look_at(options.look_from.value_or(centre + Vec3(0, 0, 1)),
                    options.look_at.value_or(centre), options.up.value_or(Vec3(0, 1, 0)), pi / 4);
    } else if (options.camera.empty() && scene.cameras.empty()) {
        camera = fit_camera(scene.bounds);
    } else if (const auto direction = view_direction(options.camera)) {
        camera = fit_camera(scene.bounds, *direction);
    } else {
        camera = file_camera(scene, options.camera.empty() ? "0" : options.camera);
    }
    if (options.fov) {
        camera.yfov = *options.fov * pi / 180;
        camera.aspect = 0;  // it is the picture's, whatever the camera's own view was
    }
    if (options.orbit != 0) {
        const Vec3 centre = scene.bounds.isEmpty() ? Vec3(0, 0, 0) : scene.bounds.center();
        camera.to_world *= Mat4().setTranslation(-centre) *
                           Mat4().setAxisAngle(Vec3(0, 1, 0), options.orbit * pi / 180) *
                           Mat4().setTranslation(centre);
    }
    return camera;
}

bool is_file(const std::string& env) { return !env.empty() && env != "studio" && env != "none"; }

/// Making an environment ready costs as much as a small picture, and a batch lights many assets
/// alike: the last one is kept.
class LastEnvironment {
  public:
    std::shared_ptr<const Environment> get(const std::string& env, const AssetOptions& options) {
        const auto key_now = [&] {
            return fmt::format("{} {} {} {}", options.env_rotation, options.load.images.max_pixels,
                               is_file(env) ? hash_file(env) : 0, env);
        };
        const std::lock_guard lock(mutex_);
        const std::string key = key_now();
        if (key == key_) return environment_;
        const Image picture =
            is_file(env) ? read_image(env, options.load.images) : studio_image();
        key_.clear();
        environment_ = std::make_shared<Environment>(picture, options.env_rotation * pi / 180);
        if (key_now() == key) key_ = key;  // the file was the same all the while
        return environment_;
    }

  private:
    std::mutex mutex_;
    std::string key_;
    std::shared_ptr<const Environment> environment_;
};

std::shared_ptr<const Environment> make_environment(const std::string& env,
                                                    const AssetOptions& options) {
    static LastEnvironment last;
    return last.get(env, options);
}

/// The scene and what lights it from outside.
struct Loaded {
    Scene scene;
    std::shared_ptr<const Environment> environment;  ///< may be nullptr
};

/// So that nobody waits for what cannot be kept.
void check_outputs(const AssetOptions& options) {
    for (const std::string& output : options.outputs) check_output(output);
    for (const std::string& file : {options.stats, options.record_rays})
        if (!file.empty()) check_place(file);
}

/// Reads the asset and, beside it, the environment.
Loaded load(const AssetOptions& options) {
    check_outputs(options);
    std::future<std::shared_ptr<const Environment>> early;
    if (!options.env.empty() && options.env != "none")
        early = std::async(std::launch::async, make_environment, options.env, std::cref(options));
    Loaded loaded{load_gltf(options.path, options.load), nullptr};
    const std::string env = chosen_environment(options, loaded.scene);
    if (env != "none")
        loaded.environment = early.valid() ? early.get() : make_environment(env, options);
    return loaded;
}

/// OpenImageIO is loaded for display pictures, textures and environments' files alone.
void add_module_need(const AssetOptions& options, const Scene& scene, Needs& needs) {
    const auto written = std::count_if(options.outputs.begin(), options.outputs.end(),
                                       [](const auto& o) { return !is_exr(o); });
    const auto decoded = std::count_if(scene.images.begin(), scene.images.end(),
                                       [](const Image& i) { return !i.empty(); });
    const std::string env = chosen_environment(options, scene);
    const bool read = is_file(env);
    const bool on = written + decoded + read > 0;
    needs.report.push_back({"image_module", on ? "on" : "off",
                            fmt::format("{} pictures written other than EXR, {} textures and {} "
                                        "environments decoded",
                                        written, decoded, int{read}),
                            on ? "" : "loading OpenImageIO and all that it links"});
}

/// Renders and writes all pictures. With a checkpoint an early end leaves them as they were.
void render_whole(const AssetOptions& options, const RenderContext& context, const RenderRun& run,
                  AssetResult& result) {
    Pictures pictures(options, context, result.intersector);
    result.picture = render(
        context, [&](const Film& band) { pictures.add(band); }, run);
    if (result.picture.tiles_done == 0)
        throw Error(options.path + ": interrupted before any tile was done; nothing is written");
    const auto write_begin = Clock::now();
    if (run.checkpoint && result.picture.tiles_done < result.picture.tiles) return;
    pictures.finish(result.picture);
    result.preview = pictures.preview();
    if (!options.record_rays.empty()) write_rays(options.record_rays, result.picture.rays);
    result.seconds.write = seconds_since(write_begin);
}

/// The same with finished tiles kept beside the first output until the pictures are written, or of
/// one part nothing but its tiles.
void render_resumable(const AssetOptions& options, const RenderContext& context, RenderRun run,
                      AssetResult& result) {
    const std::string folder =
        options.tiles.empty() ? options.outputs.at(0) + checkpoint_ending : options.tiles;
    Checkpoint checkpoint(folder,
                          tile_key(options, context.settings, result.inputs, result.intersector));
    if (checkpoint.foreign_files())
        result.warnings.push_back(fmt::format(
            "{}: {} files of tiles are of another picture (files, options or program) and not used",
            folder, checkpoint.foreign_files()));
    run.checkpoint = &checkpoint;
    if (options.part) {
        result.picture = render_part(context, *options.part, run);
        return checkpoint.sync();
    }
    const size_t missing = missing_tiles(context.settings, checkpoint);
    if (options.join && missing)
        throw Error(fmt::format("{}: {} tiles are missing; render their parts", folder, missing));
    render_whole(options, context, run, result);
    const bool complete = result.picture.tiles_done == result.picture.tiles;
    complete ? checkpoint.remove() : checkpoint.sync();
}

/// Adds what is known only at the end.
void report(const AssetOptions& options, const Scene& scene, const Intersector& intersector,
            AssetResult& result) {
    result.warnings.insert(result.warnings.begin(), scene.warnings.begin(), scene.warnings.end());
    if (scene.instances.empty()) result.warnings.push_back("there is nothing to draw");
    if (!options.aovs.empty() && std::ranges::none_of(options.outputs, is_exr))
        result.warnings.push_back("--aov: only .exr holds layers, and none is written");
    for (const std::string& warning : intersector.warnings()) result.warnings.push_back(warning);
    const RenderResult& picture = result.picture;
    if (picture.nonfinite_pixels)
        result.warnings.push_back(
            fmt::format("{} pixels are not finite", picture.nonfinite_pixels));
    result.interrupted = picture.tiles_done < picture.tiles;
    result.intersector_bytes = intersector.memory();
    result.scene_bytes = scene_memory(scene);
}

}  // namespace

std::string chosen_environment(const AssetOptions& options, const Scene& scene) {
    if (!options.env.empty()) return options.env;
    return scene.lights.empty() && !scene.background ? "studio" : "none";
}

RenderSettings make_settings(const AssetOptions& o, const Scene& scene) {
    RenderSettings settings;
    settings.width = o.width;
    settings.height = o.height;
    if (o.crop) settings.crop = *o.crop;
    settings.camera = choose_camera(o, scene);
    settings.aperture = o.aperture;
    settings.focus = o.focus;
    settings.integrator = o.integrator == "appel" ? Integrator::appel : Integrator::whitted;
    settings.depth = o.depth;
    settings.samples = settings.integrator == Integrator::appel ? 1 : o.samples;
    settings.error = settings.integrator == Integrator::appel ? 0 : o.error;
    settings.max_samples = o.max_samples;
    settings.seed = o.seed;
    settings.threads = o.threads;
    if (o.background == "transparent") {
        settings.background = Background::transparent;
    } else if (o.background.empty() ? scene.background.has_value() : o.background != "env") {
        settings.background = Background::color;
        settings.background_color =
            o.background.empty() ? *scene.background : parse_vec3(o.background);
    }
    const bool exr = std::any_of(o.outputs.begin(), o.outputs.end(), is_exr);
    if (exr) {
        settings.cutoff = 0x1p-12f;  // half a quantum of an EXR's half floats around white
        settings.half = o.half;
        if (o.aovs.empty()) settings.aovs.insert(aov_names, aov_names + default_aovs);
        settings.aovs.insert(o.aovs.begin(), o.aovs.end());
        settings.aovs.erase("beauty");  // is always there
    }
    return settings;
}

Vec3 parse_vec3(const std::string& text) {
    Vec3 v;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%f,%f,%f%c", &v.x, &v.y, &v.z, &rest) != 3 ||
        !std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z))
        throw std::invalid_argument(fmt::format("'{}' is not three finite numbers X,Y,Z", text));
    return v;
}

size_t scene_memory(const Scene& scene) {
    size_t bytes = 0;
    const auto add = [&](const auto& array) { bytes += array.size() * sizeof(array[0]); };
    for (const Mesh& mesh : scene.meshes) {
        add(mesh.positions), add(mesh.normals), add(mesh.tangents), add(mesh.colors);
        add(mesh.triangles);
        for (const auto& set : mesh.texcoords) add(set);
    }
    for (const Image& image : scene.images) bytes += image.memory();
    add(scene.instances), add(scene.shapes), add(scene.materials);
    return bytes;
}

AssetResult render_asset(const AssetOptions& options, std::stop_token stop) {
    AssetResult result;
    const auto begin = Clock::now();
    // Hashed before it is read: if it changes in between, the hash is one that will not fit again.
    if (is_file(options.env)) result.inputs.push_back({options.env, hash_file(options.env)});
    const Loaded loaded = load(options);
    const RenderSettings settings = make_settings(options, loaded.scene);
    result.inputs.insert(result.inputs.begin(), loaded.scene.files.begin(),
                         loaded.scene.files.end());
    result.seconds.load = seconds_since(begin);

    const auto build_begin = Clock::now();
    const bool lit = loaded.environment != nullptr;
    result.needs =
        options.force_all ? all_needs(settings) : find_needs(loaded.scene, settings, lit);
    result.needs.embree.isa = options.isa;
    add_module_need(options, loaded.scene, result.needs);
    const std::string engine =
        options.intersector == "auto" ? engine_name(result.needs) : options.intersector;
    const auto intersector = make_engine(loaded.scene, engine, result.needs.embree);
    const RenderContext context(loaded.scene, settings, result.needs, *intersector,
                                loaded.environment.get());
    result.seconds.build = seconds_since(build_begin);

    // Not earlier: while libraries are loaded, the threads of others may not start.
    if (!std::all_of(options.outputs.begin(), options.outputs.end(), is_exr))
        preload_image_module();
    const auto render_begin = Clock::now();
    result.intersector = intersector->description();
    result.threads = options.threads ? options.threads : std::thread::hardware_concurrency();
    const RenderRun run{.record_rays = options.keep_rays || !options.record_rays.empty(),
                        .show_progress = options.show_progress,
                        .stop = stop,
                        .checkpoint = nullptr};
    if (options.resume || options.join || options.part) {
        render_resumable(options, context, run, result);
    } else {
        render_whole(options, context, run, result);
    }
    result.seconds.render = seconds_since(render_begin) - result.seconds.write;
    report(options, loaded.scene, *intersector, result);
    result.seconds.total = seconds_since(begin);
    return result;
}

}  // namespace sightline
