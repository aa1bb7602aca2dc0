#include "commands.h"
#include "core/error.h"
#include "core/file_clash.h"
#include "core/message.h"
#include "core/text.h"
#include "help.h"
#include "interrupt.h"
#include "intersect/engines.h"
#include "intersect/ray_file.h"
#include "lab/charts.h"
#include "lab/compare/aimed_rays.h"
#include "lab/compare/answers.h"
#include "lab/compare/compare_report.h"
#include "lab/compare/compare_tables.h"
#include "lab/compare/triangle_file.h"
#include "lab/compare/verdict_file.h"
#include "options.h"
#include "output/environment_cache.h"
#include "output/render_asset.h"
#include "progress_option.h"
#include "scene/geometry_hash.h"

#include <algorithm>
#include <filesystem>
#include <memory>

namespace sightline {
namespace {

struct CompareCli {
    RenderCommand render;
    CompareOptions compare;
    std::vector<std::string> methods = {"embree-single", "embree-default",  "embree-high",
                                        "exact",         "moller-trumbore", "woop-products"};
    std::string rays, report, triangles, verdicts;
    std::vector<AimedAt> aims;  // instead of a render's rays
    size_t aimed_rays = 100000;
    uint64_t aim_seed = 1;
    std::vector<std::pair<std::string, std::string>> answers;  // names and files
    bool flat = false;
    std::optional<RecordedRay> ray;
    Tolerances tolerances;
    double max_wrong = 1;
    bool overwrite = false, quiet = false;
};

/// The command that loads the same scene; --methods and --ray are to follow.
std::string replay_command(const RenderCommand& render) {
    const LoadOptions& load = render.load;
    std::string command = "sightline compare " + shell_quoted(render.asset);
    const auto add = [&](const char* name, const std::string& value) {
        if (!value.empty()) command += fmt::format(" {} {}", name, shell_quoted(value));
    };
    add("--scene", load.scene);
    add("--variant", load.variant);
    add("--animation", load.animation);
    if (load.time) add("--time", fmt::format("{}", *load.time));
    if (load.allow_outside) command += " --allow-outside";
    add("--isa", render.engine.isa);
    return command;
}

/// The engine that renders this scene, by the name under which it is compared.
std::string production_engine(const RenderCommand& render, const Scene& scene) {
    if (render.engine.intersector != "auto") return render.engine.intersector;
    const bool lit = choose_environment(render.light, scene) != "none";
    return engine_name(find_needs(scene, complete_settings(render, scene), lit));
}

/// The engines built here, the one that renders first, then those whose answers are in files.
std::vector<Engine> engines_of(const CompareCli& cli, const Scene& scene,
                               const std::string& production, const RayFile& file = {}) {
    std::vector<std::string> names = {production};
    if (cli.methods == std::vector<std::string>{"all"}) {
        names = engine_names();
        std::erase(names, "few-shapes");
        std::erase(names, production);
        names.insert(names.begin(), production);
    } else {
        names.insert(names.end(), cli.methods.begin(), cli.methods.end());
    }
    EmbreeOptions embree;
    embree.isa = cli.render.engine.isa;
    std::vector<Engine> engines = make_engines(scene, names, embree);
    for (const auto& [name, path] : cli.answers)
        engines.push_back(read_answers(name, path, scene, file));
    return engines;
}

Scene load_scene(const RenderCommand& render) {
    LoadOptions load = render.load;
    load.decode_images = false;
    return load_gltf(render.asset, load);
}

/// Throws Error if the rays were recorded in another scene.
void check_rays_belong_to(const Scene& scene, const RayFile& file, const CompareCli& cli) {
    if (!file.geometry_hash)
        print_message(
            "warning: {}: a ray file of version 1, which does not name its scene: record "
            "it anew to have that checked\n",
            cli.rays);
    else if (*file.geometry_hash != hash_geometry(scene))
        throw Error(
            fmt::format("{}: these rays belong to other geometry than that of {} with these "
                        "options: record them anew, or give the options of the recording",
                        cli.rays, cli.render.asset));
}

void print_ray_report(const CompareCli& cli) {
    const Scene scene = load_scene(cli.render);
    const auto engines = engines_of(cli, scene, production_engine(cli.render, scene));
    const Referee referee(scene, cli.tolerances);
    fmt::print("{}", ray_text(cli.ray->ray, inspect(scene, referee, engines, *cli.ray), engines));
}

void print_summary(const CompareCli& cli, const Comparison& comparison) {
    for (const std::string& sentence : summary_sentences(comparison, cli.render.asset))
        fmt::print("{}\n", printable(sentence));
    fmt::print("{}/index.html\n", cli.report);
}

/// Throws CLI::RuntimeError with exit code 4 if production is wrong more often than allowed.
void check_production(const CompareCli& cli, const EngineScore& production) {
    if (production.total().wrong_rate().estimate * 1e6 > cli.max_wrong) throw CLI::RuntimeError(4);
}

/// All files that the comparison reads, besides those that the asset names.
std::vector<std::string> inputs_of(const CompareCli& cli) {
    std::vector<std::string> paths = {cli.render.asset, cli.render.light.env, cli.rays};
    for (const auto& [name, path] : cli.answers) paths.push_back(path);
    return paths;
}

/// All files that the comparison writes, besides charts.
std::vector<std::string> report_paths(const CompareCli& cli) {
    std::vector<std::string> paths;
    for (const char* name : report_files)
        paths.push_back((std::filesystem::path(cli.report) / name).string());
    paths.push_back(cli.render.output.record_rays);
    paths.push_back(cli.verdicts);
    return paths;
}

/// Throws Error if an interrupt has ended the comparison early; the report has the rest.
void check_complete(const CompareCli& cli, const Comparison& comparison, size_t rays) {
    if (comparison.rays_left > 0)
        throw Error(fmt::format("{}: interrupted; the report in {} is of {} of {} rays",
                                cli.render.asset, cli.report, rays - comparison.rays_left, rays));
}

/// Renders the scene and returns its rays; the picture goes to the report.
std::vector<RecordedRay> render_rays(const CompareCli& cli, const std::vector<std::string>& outputs,
                                     ReportContext& context, const std::stop_token& stop) {
    RenderCommand command = cli.render;
    command.output.keep_rays = command.output.preview = true;
    command.output.destinations = outputs;
    command.run.show_progress = !cli.quiet;
    AssetResult result = render_asset(command, stop);
    if (result.interrupted)
        throw Error(cli.render.asset +
                    ": interrupted before the rays were recorded; no report is written");
    context.rendered = std::move(result.preview);
    context.window = window_of(command.settings);
    return std::move(result.picture.rays);
}

/// The rays of --aim.
std::vector<RecordedRay> draw_rays(const CompareCli& cli, const Scene& scene) {
    auto rays = aimed_rays(scene, cli.aims, cli.aimed_rays, cli.aim_seed);
    if (!cli.render.output.record_rays.empty())
        write_rays(cli.render.output.record_rays, rays, scene);
    return rays;
}

void compare_scene(CompareCli& cli) {
    const std::stop_source interrupt = stop_on_signals();
    const std::vector<std::string> outputs = report_paths(cli);
    check_outputs_are_not_inputs(outputs, inputs_of(cli));
    RayFile file;
    if (!cli.rays.empty()) file = read_rays(cli.rays);
    claim_report(cli.report, cli.overwrite);
    ReportContext context{.command = cli.render.output.command,
                          .replay = replay_command(cli.render),
                          .production = {},
                          .max_wrong = cli.max_wrong,
                          .scene = cli.render.asset,
                          .rendered = {},
                          .window = {}};
    const bool renders = cli.rays.empty() && cli.aims.empty();
    if (renders) file.rays = render_rays(cli, outputs, context, interrupt.get_token());
    Scene scene = load_scene(cli.render);  // after the render, which has its own
    check_outputs_are_not_inputs(outputs, scene.named_files);
    if (!cli.rays.empty()) check_rays_belong_to(scene, file, cli);
    if (!cli.aims.empty()) file.rays = draw_rays(cli, scene);
    if (cli.flat) scene = flatten(scene);
    context.production = production_engine(cli.render, scene);
    const auto engines = engines_of(cli, scene, context.production, file);
    const Referee referee(scene, cli.tolerances);
    CompareOptions options = cli.compare;
    options.threads = cli.render.run.threads;
    options.show_progress = !cli.quiet;
    options.keep_verdicts = !cli.verdicts.empty();
    options.stop = interrupt.get_token();
    const Comparison comparison = compare(scene, referee, file.rays, engines, options);
    write_comparison(cli.report, comparison, scene, referee, file.rays, engines, context);
    if (!cli.verdicts.empty())
        write_verdicts(cli.verdicts, comparison, hash_geometry(scene), hash_rays(file.rays));
    if (!cli.quiet) {
        fmt::print("{}", comparison_table(comparison));
        print_summary(cli, comparison);
    }
    check_complete(cli, comparison, file.rays.size());
    check_production(cli, comparison.engines[0]);
}

void export_triangles(const CompareCli& cli) {
    const Scene scene = load_scene(cli.render);
    std::vector<std::string> inputs = scene.named_files;
    inputs.push_back(cli.render.asset);
    check_outputs_are_not_inputs(std::vector{cli.triangles}, inputs);
    if (!scene.shapes.empty())
        print_message("warning: {}: {} analytic shapes are no triangles and are left out\n",
                      cli.triangles, scene.shapes.size());
    write_triangles(cli.triangles, cli.flat ? flatten(scene) : scene);
}

void run(CompareCli& cli) {
    if (cli.ray) return print_ray_report(cli);
    if (!cli.triangles.empty()) export_triangles(cli);
    if (!cli.report.empty()) return compare_scene(cli);
    if (cli.triangles.empty())
        throw CLI::ValidationError(
            "--report DIR, --ray NUMBERS or --export-triangles FILE is required");
}

void add_foreign_engine_options(CLI::App& app, CompareCli& cli, CLI::Option* rays) {
    begin_group(app, "Engines of other programs (docs/engines.md)");
    app.add_option("--export-triangles", cli.triangles,
                   "Write the triangles as they are judged, for another program")
        ->type_name("FILE");
    app.add_flag(
        "--flatten", cli.flat,
        "Judge, and export, triangles that are rounded to floats in world space instead of "
        "instances");
    add_named_paths(app, "--answers", "NAME=FILE",
                    "Judge another program's answers to the rays of --rays beside the engines; "
                    "repeatable",
                    cli.answers)
        ->needs(rays);
}

// Why `name` cannot be compared; "" if it can.
std::string engine_problem(const std::string& name) {
    try {
        if (name != "all") check_engine_name(name);
        return "";
    } catch (const Error& e) {
        return e.what();
    }
}

/// Rays that are aimed instead of rendered.
void add_aim_options(CLI::App& app, CompareCli& cli, CLI::Option* rays) {
    CLI::Option* aim =
        app.add_option_function<std::vector<std::string>>(
               "--aim",
               [&cli](const std::vector<std::string>& names) {
                   for (const std::string& name : names) {
                       const auto found = std::ranges::find(aim_names, name);
                       if (found == std::end(aim_names))
                           throw CLI::ValidationError(
                               "--aim", fmt::format("there is no aim '{}'; there are {}", name,
                                                    fmt::join(aim_names, ", ")));
                       cli.aims.push_back(static_cast<AimedAt>(found - std::begin(aim_names)));
                   }
               },
               "Compare rays aimed at vertices, edges, silhouettes or along the surface, where "
               "methods fail, without rendering")
            ->delimiter(',')
            ->allow_extra_args(false)
            ->type_name("NAME,...")
            ->excludes(rays);
    add_number(app, "--aim-rays", cli.aimed_rays, "N", "Number of aimed rays", size_t{1},
               size_t{1000000000})
        ->needs(aim);
    add_number(app, "--aim-seed", cli.aim_seed, "N", "Seed of the aimed rays", uint64_t{0})
        ->needs(aim);
}

void add_comparison_options(CLI::App& app, CompareCli& cli) {
    begin_group(app, "Comparison");
    app.add_option("--methods", cli.methods,
                   "Engines to compare with the one that renders the scene, or all "
                   "(docs/compare.md)")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("NAME,...")
        ->check(CLI::Validator(engine_problem, {}))
        ->default_str(fmt::format("{}", fmt::join(cli.methods, ",")));
    CLI::Option* file =
        app.add_option("--rays", cli.rays,
                       "Compare the rays that --record-rays wrote, without rendering")
            ->type_name("FILE");
    add_parsed(
        app, "--ray", "NUMBERS",
        "Report on one ray instead: ox,oy,oz,dx,dy,dz,tnear,tfar, decimal or hexadecimal, and "
        "optionally its kind, then the instance, geometry and primitive that it leaves",
        [&cli](const std::string& text) { cli.ray = parse_ray(text); })
        ->excludes(file);
    add_aim_options(app, cli, file);
    add_number(app, "--max-judged", cli.compare.max_judged, "N",
               "Maximum number of rays to judge; beyond it, a sample and the rays on which engines "
               "differ",
               uint64_t{0});
    add_number(
        app, "--t-tolerance", cli.tolerances.t, "N",
        "A t is wrong if it is off by more than N times what one float ulp in every number of "
        "the ray and the surface can cause",
        0.0);
    add_number(app, "--uv-tolerance", cli.tolerances.uv, "N", "Likewise for u and v", 0.0);
    add_number(app, "--rounds", cli.compare.rounds, "N",
               "Rounds of timing, in which engines alternate", 1, 1000);
    add_foreign_engine_options(app, cli, file);
    begin_group(app, "Output");
    app.add_option("--report", cli.report, "Folder for index.html, results.json and results.csv")
        ->type_name("DIR");
    add_overwrite_option(app, cli.overwrite);
    app.add_option("--verdicts", cli.verdicts,
                   "Write the verdict on every answer to every ray (docs/engines.md)")
        ->type_name("FILE");
    app.add_option("--record-rays", cli.render.output.record_rays, "Write the compared rays")
        ->type_name("FILE")
        ->excludes(file);
    add_number(app, "--max-wrong", cli.max_wrong, "RATE",
               "Exit with 4 if the rendering engine is wrong on more rays per million", 0.0);
}

std::string list_engines() {
    std::string list = "Engines:\n";
    for (const EngineEntry& engine : engine_registry())
        list += table_row("  " + engine.name, engine.description);
    list.pop_back();
    return list;
}

}  // namespace

void add_compare_command(CLI::App& app, const std::string& command_line) {
    const auto cli = std::make_shared<CompareCli>();
    cli->render.output.command = command_line;
    cli->render.settings.samples = 1;
    CLI::App* sub = app.add_subcommand(
        "compare", "Fire a render's rays through several engines and judge each answer exactly");
    add_scene_argument(*sub, cli->render.asset);
    add_comparison_options(*sub, *cli);
    add_ray_options(*sub, cli->render);
    add_performance_options(*sub, cli->render);
    begin_group(*sub, "Other");
    add_progress_option(*sub);
    sub->add_flag("--quiet", cli->quiet, "Print no progress and no table");
    sub->footer(list_engines() + "\n\nTry `sightline compare asset.glb --report report`.");
    sub->callback([cli] { run(*cli); });
}

}  // namespace sightline
