#include "options.h"

#include "core/color.h"
#include "core/error.h"
#include "core/suggest.h"
#include "intersect/engines.h"
#include "output/data_layers.h"
#include "output/environment_cache.h"
#include "output/ground_choice.h"
#include "scene/view_names.h"
#include "shade/studio.h"

#include <unistd.h>

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>

namespace sightline {
namespace {

constexpr float any_float = std::numeric_limits<float>::lowest();
constexpr int max_samples = 1 << 20;

template <class Vector>
Vector parse_vector(const std::string& text) {
    Vec3d v;
    char rest = 0;
    const int count = std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &v.x, &v.y, &v.z, &rest);
    if (count != 3 || !is_finite(Vec3(v)))
        throw std::invalid_argument(
            fmt::format("'{}' is not three finite numbers such as 0,1.5,2", text));
    return Vector(v);
}

void parse_size(const std::string& text, RenderSettings& settings) {
    char rest = 0;
    int &w = settings.width, &h = settings.height;
    const bool is_square = std::sscanf(text.c_str(), "%d%c", &w, &rest) == 1;
    if (is_square) h = w;
    if ((!is_square && std::sscanf(text.c_str(), "%dx%d%c", &w, &h, &rest) != 2) || w < 1 ||
        h < 1 || w > 65536 || h > 65536)
        throw std::invalid_argument(fmt::format(
            "'{}' is not a size from 1x1 to 65536x65536 such as 800x600, or 800 for a square",
            text));
}

PixelRect parse_crop(const std::string& text) {
    PixelRect r;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%d,%d,%d,%d%c", &r.x0, &r.y0, &r.x1, &r.y1, &rest) != 4)
        throw std::invalid_argument(
            fmt::format("'{}' is not a rectangle such as 0,0,100,50", text));
    if (r.x0 < 0 || r.y0 < 0 || r.x1 <= r.x0 || r.y1 <= r.y0)
        throw std::invalid_argument(
            fmt::format("'{}' is empty; X0,Y0,X1,Y1 need X1 above X0 and Y1 above Y0", text));
    return r;
}

void check_crop(const RenderSettings& s) {
    if (s.crop.x1 > s.width || s.crop.y1 > s.height)
        throw CLI::ValidationError(
            "--crop", fmt::format("{},{},{},{} exceeds the picture's {}x{}", s.crop.x0, s.crop.y0,
                                  s.crop.x1, s.crop.y1, s.width, s.height));
}

template <class Vector>
CLI::Option* add_vector(CLI::App& app, const std::string& name, std::optional<Vector>& to,
                        const std::string& text) {
    return add_parsed(app, name, "X,Y,Z", text,
                      [&to](const std::string& value) { to = parse_vector<Vector>(value); });
}

FrameRange parse_frame_range(const std::string& text) {
    FrameRange times;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%d..%d@%lf%c", &times.first, &times.last, &times.fps, &rest) !=
            3 ||
        times.first < 0 || times.last < times.first || !(times.fps > 0) ||
        !std::isfinite(times.fps))
        throw std::invalid_argument(
            fmt::format("'{}' is not FIRST..LAST@FPS such as 0..47@24", text));
    return times;
}

void add_view_options(CLI::App& app, RenderCommand& command) {
    begin_group(app, "View");
    RenderSettings& settings = command.settings;
    add_parsed(app, "--size", "WxH",
               "Picture size in pixels, 1x1 to 65536x65536; one number: a square",
               [&settings](const std::string& text) { parse_size(text, settings); })
        ->default_str("512x512");
    add_parsed(app, "--crop", "X0,Y0,X1,Y1",
               "Rectangle to render, in pixels from the top left, without column X1 and row Y1",
               [&settings](const std::string& text) { settings.crop = parse_crop(text); })
        ->default_str("the whole picture");
    add_camera_options(app, command.view);
    add_vector(app, "--up", command.view.up, "Up direction of a free camera")->default_str("0,1,0");
    add_number(app, "--fov", command.view.fov, "DEGREES", "Vertical field of view", 0.01f, 179.0f)
        ->default_str("the file's camera's, else 45");
    add_aperture_option(app, settings);
    add_number(app, "--f-stop", command.view.f_stop, "N",
               "Aperture as on a lens before 24 mm of film, in scenes whose unit is the metre; "
               "2.8: shallow, 16: deep",
               0.1f, 1000.0f)
        ->default_str("off")
        ->excludes(app.get_option("--aperture"))
        ->excludes(app.get_option("--ortho"));
    add_number(app, "--focus", settings.focus, "DISTANCE",
               "Distance from the camera to the plane in focus, in world units", 0.0f)
        ->default_str("to the scene's centre");
}

void add_light_options(CLI::App& app, LightOptions& light) {
    begin_group(app, "Light");
    add_environment_option(app, light);
    add_number(app, "--env-rotation", light.env_rotation, "DEGREES",
               "Rotation of the environment about +y", any_float);
    add_number(app, "--env-brightness", light.env_brightness, "F",
               "Factor of the light of the environment or built-in light", 0.0f);
    add_number(app, "--env-blur", light.env_blur, "DEGREES",
               "Blur of the environment as the camera sees it behind the scene, not of its light: "
               "the radius of the spot that a point becomes",
               0.0f, 90.0f);
    add_parsed(app, "--background", "env|transparent|COLOUR",
               "Background: the environment, none (alpha 0) or a colour: a name such as white, "
               "#RRGGBB, or linear light R,G,B from 0 to 1; pictures show its code value whatever "
               "the tone map",
               [&light](const std::string& text) {
                   light.background = text == "env"           ? Background::environment
                                      : text == "transparent" ? Background::transparent
                                                              : Background::color;
                   if (light.background == Background::color)
                       light.background_color = parse_color(text);
               })
        ->default_str("the file's, else #B0B0B0 in a built-in light, else env");
}

void parse_ground(const std::string& text, GroundOptions& ground) {
    ground.kind = text == "none"        ? GroundKind::nothing
                  : text == "shadow"    ? GroundKind::shadow
                  : text == "cyclorama" ? GroundKind::cyclorama
                                        : GroundKind::matte;
    if (ground.kind != GroundKind::matte) return;
    try {
        ground.color = parse_color(text);
    } catch (const Error& e) {
        const std::vector<std::string> names{"none", "shadow", "cyclorama"};
        throw Error(fmt::format("{}; the grounds beside a colour are {}{}", e.what(),
                                fmt::join(names, ", "), did_you_mean(text, names)));
    }
}

void add_ground_options(CLI::App& app, GroundOptions& ground) {
    add_parsed(app, "--ground", "none|shadow|cyclorama|COLOUR",
               "What stands below the scene: shadow: a plane on which only shadows and reflections "
               "show, on any background; cyclorama: a matte one that becomes the background's "
               "colour at a distance; a matte one of this colour",
               [&ground](const std::string& text) { parse_ground(text, ground); })
        ->default_str("none");
    add_number(app, "--ground-height", ground.height, "Y", "Height of the ground, in world units",
               std::numeric_limits<double>::lowest())
        ->default_str("the lowest point of the scene, in all frames of an animation");
    add_number(app, "--ground-mirror", ground.mirror, "SHARE",
               "Part of the light, from 0 to 1, that a shadow ground mirrors as seen from above; "
               "more at an angle, 0: none",
               0.0f, 1.0f);
}

void add_single_sided_option(CLI::App& app, RenderSettings& settings) {
    add_choice<SingleSidedShadows>(
        app, "--single-sided-shadows", settings.single_sided_shadows,
        "Whether single-sided faces hold off light that arrives at their undrawn backs; auto: not "
        "those that are unlit or whose backs this view looks through (docs/shadows.md)",
        {{"auto", SingleSidedShadows::automatic},
         {"on", SingleSidedShadows::on},
         {"off", SingleSidedShadows::off}});
}

void add_quality_options(CLI::App& app, RenderSettings& settings) {
    begin_group(app, "Quality");
    add_transport_options(app, settings);
    add_single_sided_option(app, settings);
    CLI::Option* samples =
        add_number(app, "--samples", settings.samples, "N", "Samples per pixel", 1, max_samples);
    add_number(app, "--error", settings.error, "E",
               "Sample noisy pixels more, until the picture's relative error is below E", 1e-6f,
               1.0f)
        ->excludes(samples)
        ->default_str("off");
    add_number(app, "--max-samples", settings.max_samples, "N",
               "Maximum samples per pixel with --error", 1, max_samples);
    app.add_flag("--full-textures", settings.full_textures,
                 "Decode and keep each texture in full, even where the view reads no more than a "
                 "coarser level");
    add_number(app, "--seed", settings.seed, "N", "Seed of the random numbers", 0u);
}

}  // namespace

CLI::Validator one_of(const std::vector<std::string>& words) {
    const auto check = [words](std::string& text) -> std::string {
        if (std::ranges::find(words, text) != words.end()) return {};
        return fmt::format("'{}' is not one of {}{}", text, fmt::join(words, ", "),
                           did_you_mean(text, words));
    };
    return {check, fmt::format("{{{}}}", fmt::join(words, ","))};
}

void expand_exponent(std::string& text) {
    constexpr double exact = 9007199254740992;  // 2^53
    if (text.find_first_of("eE") == std::string::npos) return;
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    const bool is_number = *end == 0 && std::isdigit(static_cast<unsigned char>(text.back()));
    if (is_number && value == std::floor(value) && std::abs(value) <= exact)
        text = fmt::format("{:.0f}", value);
}

CLI::Validator positive_number() {
    const auto check = [](std::string& text) -> std::string {
        double value = 0;
        if (CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value)) return {};
        return fmt::format("'{}' is not a finite number above 0", text);
    };
    return {check, ""};
}

CLI::Option* add_named_paths(CLI::App& app, const std::string& name, const std::string& form,
                             const std::string& text,
                             std::vector<std::pair<std::string, std::string>>& to) {
    const auto store = [&to, name, form](const std::vector<std::string>& values) {
        for (const std::string& value : values) {
            const size_t equals = value.find('=');
            if (equals == 0 || equals == std::string::npos)
                throw CLI::ValidationError(name, "'" + value + "' is not of the form " + form);
            to.emplace_back(value.substr(0, equals), value.substr(equals + 1));
        }
    };
    return app.add_option_function<std::vector<std::string>>(name, store, text)->type_name(form);
}

CLI::Option* add_parsed(CLI::App& app, const std::string& name, const std::string& value,
                        const std::string& text,
                        const std::function<void(const std::string&)>& store) {
    const auto checked = [name, store](const std::string& argument) {
        try {
            store(argument);
        } catch (const std::invalid_argument& e) {
            throw CLI::ValidationError(name, e.what());
        } catch (const Error& e) {
            throw CLI::ValidationError(name, e.what());
        }
    };
    return app.add_option_function<std::string>(name, checked, text)->type_name(value);
}

void add_scene_argument(CLI::App& app, std::string& path) {
    const auto check = [](const std::string& name) -> std::string {
        std::error_code ignored;
        if (name == standard_input && isatty(STDIN_FILENO))
            return "standard input is a terminal; send it an asset, as in `sightline render - ... "
                   "< asset.glb`";
        return std::filesystem::is_directory(name, ignored)
                   ? name + " is a folder; batch renders the files in a folder"
                   : "";
    };
    app.add_option("SCENE", path, "glTF file, .gltf or .glb; -: standard input")
        ->required()
        ->type_name("FILE")
        ->check(CLI::Validator(check, {}));
}

void add_load_options(CLI::App& app, LoadOptions& load) {
    begin_group(app, "Input");
    app.add_option("--scene", load.scene, "Scene of the file")
        ->type_name("NAME|INDEX")
        ->default_str("the file's default");
    app.add_option("--variant", load.variant, "Material variant (KHR_materials_variants)")
        ->type_name("NAME|INDEX")
        ->default_str("none");
    app.add_option("--animation", load.animation, "Animation to pose")
        ->type_name("NAME|INDEX|all")
        ->default_str("the first with --time, else none");
    add_number(app, "--time", load.time, "SECONDS", "Time at which animations are posed", any_float)
        ->default_str("0 with --animation, else the rest pose");
    app.add_flag("--allow-outside", load.allow_outside,
                 "Allow the file to refer to files outside its own folder");
    app.add_flag("--strict", load.strict,
                 "Refuse the file at its first fault instead of drawing what can be drawn");
    add_number(app, "--max-elements", load.max_elements, "N",
               "Maximum size of an accessor, in elements", uint64_t{0});
    add_number(app, "--max-accessor-values", load.max_accessor_values, "N",
               "Maximum count of numbers read from all accessors together", uint64_t{0});
}

/// Options of commands that decode images.
void add_texture_options(CLI::App& app, LoadOptions& load) {
    add_choice<MissingTexture>(
        app, "--missing-texture", load.missing_texture,
        "What stands for a base colour texture whose image is missing or damaged",
        {{"factor", MissingTexture::factor}, {"checker", MissingTexture::checker}});
    add_number(app, "--max-image-pixels", load.images.max_pixels, "N",
               "Maximum size of an image, in pixels", uint64_t{0});
    add_number(app, "--max-env-bytes", load.images.max_file_bytes, "BYTES",
               "Maximum size of the environment's file", uint64_t{0});
    add_number(app, "--max-texture-memory", load.max_texture_memory, "MIB",
               "Maximum size of all decoded textures of the file together", uint64_t{0})
        ->default_str("half of the machine's memory");
}

// What is wrong with a value of --camera that cannot be a camera's name; "" if nothing is.
std::string camera_problem(const std::string& camera) {
    try {
        find_view(camera);
        return "";
    } catch (const Error& e) {
        return e.what();
    }
}

void add_camera_options(CLI::App& app, ViewOptions& view) {
    app.add_option("--camera", view.camera,
                   "Camera of the file, or a view that frames the scene: " + describe_views())
        ->check(CLI::Validator(camera_problem, {}))
        ->type_name("NAME|INDEX|VIEW")
        ->default_str("the file's first, else fit");
    add_number(app, "--orbit", view.orbit, "DEGREES",
               "Turn the camera by this angle about +y through the scene's centre; a view frames "
               "the scene alike for all angles",
               any_float)
        ->default_str("0");
    add_number(app, "--margin", view.margin, "PERCENT",
               "Part of the picture's width and height that a view leaves free on each side of the "
               "scene",
               0.0f, 45.0f)
        ->default_str(fmt::format("{}", default_margin));
    CLI::Option* ortho =
        app.add_flag("--ortho", view.ortho, "Make views that frame the scene orthographic");
    app.add_flag("--frame-each", view.frame_each,
                 "Frame each picture of a turntable or an animation for itself");
    add_parsed(app, "--frame-for", "FIRST..LAST@FPS",
               "Frame the scene for all these frames of its animation, as batch does with --frames",
               [&view](const std::string& text) { view.frame_for = parse_frame_range(text); })
        ->default_str("for this picture");
    add_vector(app, "--look-from", view.look_from, "Position of a free camera, in world units")
        ->default_str("one unit in front of the scene's centre")
        ->excludes(ortho);
    add_vector(app, "--look-at", view.look_at, "Target of a free camera, in world units")
        ->default_str("the scene's centre")
        ->excludes(ortho);
}

void add_aperture_option(CLI::App& app, RenderSettings& settings) {
    add_number(app, "--aperture", settings.aperture, "DIAMETER",
               "Diameter of the lens in world units; 0: everything is in focus", 0.0f);
}

void check_view(const ViewOptions& view) {
    if (view.look_from && view.look_from == view.look_at)
        throw CLI::ValidationError("--look-at", "must differ from --look-from");
    if (view.up == Vec3(0, 0, 0)) throw CLI::ValidationError("--up", "must not be 0,0,0");
}

void add_environment_option(CLI::App& app, LightOptions& light) {
    CLI::Option* env =
        app.add_option("--env", light.env, "Equirectangular picture that lights the scene")
            ->type_name("FILE")
            ->default_str("none");
    std::vector<std::string> lights(light_names().begin(), light_names().end());
    lights.emplace_back("none");
    app.add_option("--light", light.env,
                   "Built-in light, which the camera does not see: studio (soft lights on all "
                   "sides), softbox (one, from the upper left), three-point (key, fill and rim), "
                   "outdoor (sun and sky), or none beside the file's own lights")
        ->type_name("NAME")
        ->check(one_of(lights))
        ->excludes(env)
        ->default_str("studio if the file has no background and no lights or dark ones, else none");
}

void add_transport_options(CLI::App& app, RenderSettings& settings) {
    add_choice<Integrator>(app, "--integrator", settings.integrator, "Light transport",
                           {{"whitted", Integrator::whitted}, {"appel", Integrator::appel}});
    add_number(app, "--depth", settings.depth, "N",
               "Maximum reflections and refractions along a path", 0, 1000);
}

void add_ray_options(CLI::App& app, RenderCommand& command) {
    add_load_options(app, command.load);
    add_texture_options(app, command.load);
    add_view_options(app, command);
    add_light_options(app, command.light);
    add_ground_options(app, command.ground);
    add_quality_options(app, command.settings);
    app.parse_complete_callback([&command] {
        check_crop(command.settings);
        check_view(command.view);
        for (const std::string& problem : {ground_problem(command), light_problem(command)})
            if (!problem.empty()) throw CLI::ValidationError(problem);
    });
}

void add_display_options(CLI::App& app, OutputOptions& output) {
    begin_group(app, "Output");
    add_number(app, "--exposure", output.exposure, "STOPS", "Exposure of pictures other than EXR",
               -64.0f, 64.0f);
    add_parsed(
        app, "--alpha-for", "COLOUR",
        "Colour that a transparent picture with a shadow ground will be laid over: its alpha "
        "is fitted for that",
        [&output](const std::string& text) { output.alpha_for = parse_color(text); })
        ->default_str("white");
    CLI::Option* tone_map = add_choice<ToneMap>(app, "--tone-map", output.tone_map,
                                                "Tone map of pictures other than EXR and HDR",
                                                {{"pbr-neutral", ToneMap::pbr_neutral},
                                                 {"aces", ToneMap::aces},
                                                 {"agx", ToneMap::agx},
                                                 {"none", ToneMap::linear}});
    app.add_option("--ocio", output.color_view.config,
                   "OpenColorIO configuration whose view takes the place of the tone map")
        ->type_name("FILE")
        ->default_str("with --ocio-view the environment variable OCIO, else none")
        ->excludes(tone_map);
    add_parsed(app, "--ocio-view", "[DISPLAY/]VIEW", "View of the OpenColorIO configuration",
               [&view = output.color_view](const std::string& text) {
                   const size_t slash = text.find('/');
                   view.display = slash == std::string::npos ? "" : text.substr(0, slash);
                   view.view = slash == std::string::npos ? text : text.substr(slash + 1);
                   if (view.view.empty()) throw Error("a view has a name, as in sRGB/Film");
               })
        ->default_str("the configuration's default")
        ->excludes(tone_map);
}

void add_layer_options(CLI::App& app, RenderCommand& command) {
    begin_group(app, "Layers");
    std::vector<std::string> layers{"beauty"};
    layers.insert(layers.end(), std::begin(aov_names), std::end(aov_names));
    app.add_option("--aov", command.settings.aovs,
                   "Layers of an EXR besides beauty; beauty alone: no others")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("NAME,...")
        ->check(one_of(layers))
        ->default_str("all but cryptomatte and lights");
    app.add_option("--data", command.output.data,
                   "Layers to write as 16-bit PNG beside the first picture, such as a.depth.png "
                   "for a.png (docs/data_sets.md)")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("NAME,...")
        ->check(one_of({data_layers.begin(), data_layers.end()}))
        ->default_str("none");
    app.add_option("--depth-scale", command.output.depth_scale,
                   "World units of a step of --data depth; 0.001: millimetres, if the unit is the "
                   "metre")
        ->type_name("UNITS")
        ->check(positive_number())
        ->default_str("by picture, so that its greatest depth gets 65535");
    add_choice<bool>(app, "--exr-type", command.settings.half, "Type of colours and normals",
                     {{"float", false}, {"half", true}});
    ExrOptions& exr = command.output.exr;
    add_choice<bool>(app, "--exr-layout", exr.tiled, "Order of pixels in the file",
                     {{"scanline", false}, {"tiled", true}});
    add_choice<bool>(app, "--exr-parts", exr.multipart, "One part for all layers, or one for each",
                     {{"single", false}, {"multi", true}});
    std::vector<std::pair<std::string, std::string>> compressions;
    for (const char* name : exr_compressions) compressions.emplace_back(name, name);
    add_choice(app, "--exr-compression", exr.compression, "Lossless compression", compressions);
}

void add_performance_options(CLI::App& app, RenderCommand& command) {
    begin_group(app, "Performance");
    add_number(app, "--threads", command.run.threads, "N", "Threads", 1u, 4096u)
        ->default_str("all cores");
    app.add_option("--isa", command.engine.isa, "Instruction set of Embree")
        ->type_name("NAME")
        ->check(one_of({"sse2", "sse4.2", "avx", "avx2", "avx512"}))
        ->default_str("the best of this machine");
    add_parsed(app, "--intersector", "NAME",
               "Intersection engine, as for `compare --methods`; auto: the fastest that suits the "
               "scene",
               [&engine = command.engine](const std::string& name) {
                   if (name != "auto") check_engine_name(name);
                   engine.intersector = name;
               })
        ->default_str(command.engine.intersector);
}

void add_overwrite_option(CLI::App& app, bool& overwrite) {
    app.add_flag("--overwrite", overwrite,
                 "Replace files of the report's folder that this program did not make; by default "
                 "they are an error");
}

}  // namespace sightline
