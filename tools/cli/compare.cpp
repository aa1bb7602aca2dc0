#include "core/error.h"
#include "core/text.h"
#include "intersect/ray_file.h"
#include "lab/compare/compare_report.h"
#include "lab/compare/compare_tables.h"
#include "options.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

namespace sightline {
namespace {

struct CompareCommand {
    AssetOptions render;
    CompareOptions compare;
    std::vector<std::string> methods = {"embree-single", "embree-default", "exact",
                                        "moller-trumbore", "woop-products"};
    std::string rays, ray, report;
    double max_wrong = 1;
    bool quiet = false;
};

/// The command that loads the same scene; --methods and --ray are to follow.
std::string replay_command(const AssetOptions& options) {
    const LoadOptions& load = options.load;
    std::string command = "sightline compare " + shell_quoted(options.path);
    const auto add = [&](const char* name, const std::string& value) {
        if (!value.empty()) command += fmt::format(" {} {}", name, shell_quoted(value));
    };
    add("--scene", load.scene);
    add("--variant", load.variant);
    add("--animation", load.animation);
    if (load.time) add("--time", fmt::format("{}", *load.time));
    if (load.allow_outside) command += " --allow-outside";
    add("--isa", options.isa);
    return command;
}

/// The engine that renders this scene, by the name under which it is compared.
std::string production_engine(const AssetOptions& options, const Scene& scene) {
    if (options.intersector != "auto") return options.intersector;
    const bool lit = chosen_environment(options, scene) != "none";
    return engine_name(find_needs(scene, make_settings(options, scene), lit));
}

std::vector<Engine> engines_of(const CompareCommand& command, const Scene& scene,
                               const std::string& production) {
    std::vector<std::string> names = {production};
    if (command.methods == std::vector<std::string>{"all"}) {
        names = engine_names();
        std::erase(names, "few-shapes");
        std::erase(names, production);
        names.insert(names.begin(), production);
    } else {
        names.insert(names.end(), command.methods.begin(), command.methods.end());
    }
    EmbreeOptions embree;
    embree.isa = command.render.isa;
    return make_engines(scene, names, embree);
}

void check_methods(const CompareCommand& command) {
    if (command.methods != std::vector<std::string>{"all"})
        for (const std::string& name : command.methods) check_engine_name(name);
}

Scene load_scene(const AssetOptions& options) {
    LoadOptions load = options.load;
    load.decode_images = false;
    return load_gltf(options.path, load);
}

Ray parse(const std::string& text) {
    try {
        return parse_ray(text);
    } catch (const std::invalid_argument& e) {
        throw CLI::ValidationError("--ray", e.what());
    }
}

/// One ray, told on the terminal.
void tell_ray(const CompareCommand& command) {
    const Ray ray = parse(command.ray);
    const Scene scene = load_scene(command.render);
    const auto engines = engines_of(command, scene, production_engine(command.render, scene));
    const Referee referee(scene);
    fmt::print("{}", ray_text(ray, inspect(scene, referee, engines, ray), engines));
}

/// Throws what makes the program end with 4 where production is wrong more often than allowed.
void conclude(const CompareCommand& command, const EngineScore& production) {
    const Tally total = production.total();
    const double rate = 1e6 * static_cast<double>(total.wrong()) /
                        static_cast<double>(std::max<uint64_t>(total.judged(), 1));
    if (!command.quiet)
        fmt::print("{}: {} wrong of {} judged rays, per million {}\n{}/index.html\n",
                   production.name, total.wrong(), total.judged(),
                   per_million(total.wrong(), total.judged()), command.report);
    if (rate > command.max_wrong) throw CLI::RuntimeError(4);
}

void compare_scene(CompareCommand& command) {
    check_methods(command);
    std::vector<RecordedRay> rays;
    if (!command.rays.empty()) rays = read_rays(command.rays);
    std::filesystem::create_directories(command.report);
    ReportContext context{.command = command.render.command,
                          .replay = replay_command(command.render),
                          .production = {},
                          .max_wrong = command.max_wrong,
                          .scene = command.render.path,
                          .rendered = {},
                          .window = {}};
    if (command.rays.empty()) {
        AssetOptions options = command.render;
        options.keep_rays = options.preview = true;
        options.show_progress = !command.quiet;
        AssetResult result = render_asset(options);
        context.rendered = std::move(result.preview);
        context.window = options.crop.value_or(PixelRect{0, 0, options.width, options.height});
        rays = std::move(result.picture.rays);
    }
    const Scene scene = load_scene(command.render);
    context.production = production_engine(command.render, scene);
    const auto engines = engines_of(command, scene, context.production);
    const Referee referee(scene);
    CompareOptions options = command.compare;
    options.threads = command.render.threads;
    options.show_progress = !command.quiet;
    const Comparison comparison = compare(scene, referee, rays, engines, options);
    write_comparison(command.report, comparison, scene, referee, rays, engines, context);
    if (!command.quiet) fmt::print("{}", comparison_table(comparison));
    conclude(command, comparison.engines[0]);
}

void run(CompareCommand& command) {
    if (!command.ray.empty()) return tell_ray(command);
    if (command.report.empty()) throw CLI::RequiredError("--report or --ray");
    compare_scene(command);
}

void add_options(CLI::App& app, CompareCommand& c) {
    app.add_option("--report", c.report, "Folder for index.html, results.json and results.csv")
        ->type_name("DIR");
    auto* file = app.add_option("--rays", c.rays,
                                "Compare the rays that --record-rays wrote, instead of rendering")
                     ->type_name("FILE");
    app.add_option("--ray", c.ray, "Tell what becomes of one ray: ox,oy,oz,dx,dy,dz,tnear,tfar")
        ->type_name("NUMBERS")
        ->excludes(file);
    app.add_option("--methods", c.methods,
                   "Engines beside the one that renders the scene, or all (docs/compare.md)")
        ->delimiter(',')
        ->capture_default_str();
    app.add_option("--max-wrong", c.max_wrong,
                   "Exit with 4 where the rendering engine is wrong on more rays per million")
        ->capture_default_str()
        ->check(CLI::NonNegativeNumber);
    app.add_option("--max-judged", c.compare.max_judged,
                   "Beyond so many rays, judge a sample and those on which engines differ")
        ->capture_default_str();
    app.add_option("--rounds", c.compare.rounds, "Rounds of timing")
        ->capture_default_str()
        ->check(CLI::Range(1, 1000));
    app.add_option("--record-rays", c.render.record_rays, "Write the rays that are compared")
        ->type_name("FILE")
        ->excludes(file);
    app.add_flag("--quiet", c.quiet, "No progress, no table");
}

}  // namespace

void add_compare_command(CLI::App& app, const std::string& command_line) {
    const auto command = std::make_shared<CompareCommand>();
    command->render.command = command_line;
    command->render.samples = 1;
    CLI::App* sub = app.add_subcommand(
        "compare", "Fire a render's rays through several engines and let exact arithmetic judge");
    sub->add_option("SCENE", command->render.path, ".gltf or .glb file")
        ->required()
        ->type_name("FILE");
    add_options(*sub, *command);
    add_scene_options(*sub, command->render);
    add_picture_options(*sub, command->render);
    sub->callback([command] { run(*command); });
}

}  // namespace sightline
