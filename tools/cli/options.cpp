#include "options.h"

#include "core/error.h"
#include "intersect/engines.h"

#include <fmt/format.h>

#include <cstdlib>
#include <limits>

namespace sightline {
namespace {

template <class Store>
CLI::Option* add_parsed(CLI::App& app, const std::string& name, Store store,
                        const std::string& help, const std::string& type) {
    return app
        .add_option_function<std::string>(
            name,
            [store](const std::string& text) {
                try {
                    store(text);
                } catch (const std::invalid_argument& e) {
                    throw CLI::ValidationError(e.what());
                } catch (const Error& e) {
                    throw CLI::ValidationError(e.what());
                }
            },
            help)
        ->type_name(type);
}

/// A number that is not finite passes CLI11's own ranges.
CLI::Validator finite_between(float low, float high) {
    return {[low, high](std::string& text) -> std::string {
                const float value = std::strtof(text.c_str(), nullptr);
                if (value >= low && value <= high) return {};
                return fmt::format("{} is not between {} and {}", text, low, high);
            },
            "FLOAT"};
}

constexpr float any = std::numeric_limits<float>::max();

void parse_size(const std::string& text, AssetOptions& options) {
    char rest = 0;
    if (std::sscanf(text.c_str(), "%dx%d%c", &options.width, &options.height, &rest) != 2 ||
        options.width < 1 || options.height < 1 || options.width > 65536 || options.height > 65536)
        throw std::invalid_argument(
            fmt::format("'{}' is not a size WxH between 1x1 and 65536x65536", text));
}

PixelRect parse_crop(const std::string& text) {
    PixelRect r;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%d,%d,%d,%d%c", &r.x0, &r.y0, &r.x1, &r.y1, &rest) != 4)
        throw std::invalid_argument(fmt::format("'{}' is not a rectangle X0,Y0,X1,Y1", text));
    return r;
}

void check_camera(const AssetOptions& o) {
    if (o.look_from && o.look_from == o.look_at)
        throw CLI::ValidationError("--look-at", "is where --look-from stands");
    if (o.up == Vec3(0, 0, 0)) throw CLI::ValidationError("--up", "0,0,0 is no direction");
}

void check_crop(const AssetOptions& o) {
    if (!o.crop) return;
    const PixelRect& r = *o.crop;
    if (r.x0 < 0 || r.y0 < 0 || r.x1 <= r.x0 || r.y1 <= r.y0 || r.x1 > o.width || r.y1 > o.height)
        throw CLI::ValidationError(
            fmt::format("--crop {},{},{},{} is empty or not within the picture of {}x{}", r.x0,
                        r.y0, r.x1, r.y1, o.width, o.height));
}

void add_view_options(CLI::App& app, AssetOptions& o) {
    const auto vec3 = [&](const char* name, std::optional<Vec3>& to, const char* help) {
        add_parsed(
            app, name, [&to](const std::string& s) { to = parse_vec3(s); }, help, "X,Y,Z");
    };
    add_parsed(
        app, "--size", [&o](const std::string& s) { parse_size(s, o); }, "Picture size [512x512]",
        "WxH");
    app.add_option("--camera", o.camera,
                   "Camera of the file, or one that fits everything: fit, front, back, left, "
                   "right, top, bottom")
        ->type_name("NAME|INDEX|fit|SIDE");
    app.add_option("--orbit", o.orbit, "Move the camera round the scene's centre about +y")
        ->type_name("DEG")
        ->check(finite_between(-any, any));
    vec3("--look-from", o.look_from, "Free camera: where it stands");
    vec3("--look-at", o.look_at, "Free camera: what it looks at");
    vec3("--up", o.up, "Free camera: its up direction [0,1,0]");
    app.add_option("--fov", o.fov, "Vertical field of view")
        ->type_name("DEG")
        ->check(finite_between(0.01f, 179));
    app.add_option("--aperture", o.aperture, "Diameter of the lens, for depth of field")
        ->check(finite_between(0, any));
    app.add_option("--focus", o.focus, "Distance in focus (default: the scene's centre)")
        ->check(finite_between(0, any));
}

void add_light_options(CLI::App& app, AssetOptions& o) {
    app.add_option("--env", o.env, "Environment (default: studio where the file brings no light)")
        ->type_name("FILE|studio|none");
    app.add_option("--env-rotation", o.env_rotation, "Turn the environment about +y")
        ->type_name("DEG")
        ->check(finite_between(-any, any));
    add_parsed(
        app, "--background",
        [&o](const std::string& s) {
            if (s != "env" && s != "transparent") parse_vec3(s);
            o.background = s;
        },
        "What lies behind (default: the file's, else the environment)", "env|transparent|R,G,B");
    app.add_option("--exposure", o.exposure, "Brighten display pictures")
        ->type_name("EV")
        ->check(finite_between(-64, 64));
    app.add_option("--tone-map", o.tone_map, "For display pictures")
        ->capture_default_str()
        ->check(CLI::IsMember({"pbr-neutral", "aces", "agx", "none"}));
}

void add_sampling_options(CLI::App& app, AssetOptions& o) {
    app.add_option("--integrator", o.integrator, "Light transport")
        ->capture_default_str()
        ->check(CLI::IsMember({"whitted", "appel"}));
    app.add_option("--depth", o.depth, "Most reflections and refractions in a row")
        ->capture_default_str()
        ->check(CLI::Range(0, 1000));
    auto* samples = app.add_option("--samples", o.samples, "Samples per pixel (appel: always 1)")
                        ->capture_default_str()
                        ->check(CLI::Range(1, 1 << 20));
    app.add_option("--error", o.error, "Sample each pixel until its relative error is below")
        ->type_name("REL")
        ->check(finite_between(1e-6f, 1))
        ->excludes(samples);
    app.add_option("--max-samples", o.max_samples, "Bound of --error")
        ->capture_default_str()
        ->check(CLI::Range(1, 1 << 20));
    app.add_option("--seed", o.seed, "Another seed, other noise")->capture_default_str();
    add_parsed(
        app, "--crop", [&o](const std::string& s) { o.crop = parse_crop(s); },
        "Render this part only (pixels, y down)", "X0,Y0,X1,Y1");
    app.add_option("--threads", o.threads, "Threads (default: all cores)")
        ->check(CLI::Range(1, 4096));
    app.add_option("--isa", o.isa, "Pin Embree's instruction set")
        ->check(CLI::IsMember({"sse2", "sse4.2", "avx", "avx2", "avx512"}));
    add_parsed(
        app, "--intersector",
        [&o](const std::string& s) {
            if (s != "auto") check_engine_name(s);
            o.intersector = s;
        },
        "Intersection engine, as for `compare --methods`; auto: the cheapest that serves the scene",
        "NAME")
        ->default_str(o.intersector);
}

void add_layer_options(CLI::App& app, AssetOptions& o) {
    std::vector<std::string> names(std::begin(aov_names), std::end(aov_names));
    names.insert(names.begin(), "beauty");
    app.add_option("--aov", o.aovs,
                   "Layers for EXR beside beauty, which alone is `beauty` (default: all but "
                   "cryptomatte and lights)")
        ->delimiter(',')
        ->check(CLI::IsMember(names));
    const auto choice = [&](const char* name, bool& to, const char* off, const char* on,
                            const char* help) {
        const std::string chosen = on;
        app.add_option_function<std::string>(
               name, [&to, chosen](const std::string& s) { to = s == chosen; }, help)
            ->check(CLI::IsMember({off, on}));
    };
    choice("--exr-type", o.half, "float", "half", "Colours and normals in EXR [float]");
    choice("--exr-layout", o.exr.tiled, "scanline", "tiled", "Pixels in EXR [scanline]");
    choice("--exr-parts", o.exr.multipart, "single", "multi",
           "All layers in one part of an EXR, or a part for each [single]");
    app.add_option("--exr-compression", o.exr.compression, "Of EXR, without loss")
        ->capture_default_str()
        ->check(CLI::IsMember(
            std::vector<std::string>(std::begin(exr_compressions), std::end(exr_compressions))));
}

}  // namespace

void add_scene_options(CLI::App& app, AssetOptions& o) {
    app.add_option("--scene", o.load.scene, "Scene of the file")->type_name("NAME|INDEX");
    app.add_option("--variant", o.load.variant, "Material variant")->type_name("NAME|INDEX");
    app.add_option("--time", o.load.time,
                   "Pose animations at this time (with --animation default: 0)")
        ->type_name("SECONDS")
        ->check(finite_between(-any, any));
    app.add_option("--animation", o.load.animation, "Animation to pose (default: all)")
        ->type_name("NAME|INDEX|all");
    app.add_flag("--allow-outside", o.load.allow_outside,
                 "Let the file read from outside its own folder");
    app.add_option("--max-image-pixels", o.load.images.max_pixels, "Refuse images with more pixels")
        ->capture_default_str();
    app.add_option("--max-elements", o.load.max_elements, "Refuse accessors with more elements")
        ->capture_default_str();
    app.add_option("--max-values", o.load.max_values, "Refuse files that use more numbers")
        ->capture_default_str();
}

void add_picture_options(CLI::App& app, AssetOptions& o) {
    add_view_options(app, o);
    add_light_options(app, o);
    add_sampling_options(app, o);
    add_layer_options(app, o);
    app.parse_complete_callback([&o] {
        check_crop(o);
        check_camera(o);
    });
}

}  // namespace sightline
