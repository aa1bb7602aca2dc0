#include "batch/plan.h"
#include "commands.h"
#include "core/error.h"
#include "core/files.h"
#include "core/message.h"
#include "core/text.h"
#include "interrupt.h"
#include "output/formats.h"
#include "output/render_asset.h"
#include "picture_options.h"
#include "progress_option.h"
#include "render_run.h"
#include "standard_output.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <memory>
#include <set>

namespace sightline {
namespace {

namespace fs = std::filesystem;

struct RenderCli {
    RenderCommand command;
    std::vector<const CLI::Option*> settings;  // those that are given go to each picture
    std::vector<std::string> views;
    Ring turntable;
    FrameOptions frames;
    ReportOptions report;
    PosesOptions poses;
    std::string format = "png";  // of the picture for standard output
    StandardOutput standard_output;
};

/// What an interrupted render may take to write the tiles in flight; finished tiles that are kept
/// stay in any case.
constexpr auto stop_limit = std::chrono::milliseconds(1500);

PicturePart parse_part(const std::string& text) {
    PicturePart part;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%u/%u%c", &part.index, &part.count, &rest) != 2 ||
        part.index < 1 || part.index > part.count)
        throw std::invalid_argument(fmt::format("'{}' is not a part I/N such as 1/8", text));
    --part.index;
    return part;
}

std::string render_output_problem(const std::string& path) {
    return path == "-" || is_movie(path) ? "" : format_problem(path);
}

void add_output_options(CLI::App& app, OutputOptions& output) {
    begin_group(app, "Output");
    app.add_option("-o,--output", output.pictures,
                   "Picture to write, .exr .png .jpg .tif .webp or .hdr; may be repeated; with "
                   "--views a template such as a_{view}.png, with --turntable or --frames "
                   "a_{frame:04}.png, or one film of all frames, .mp4 .webm .gif or .webp, which "
                   "needs the ffmpeg program; -: standard output")
        ->required()
        ->type_name("FILE")
        ->check(CLI::Validator(render_output_problem, {}))
        ->allow_extra_args(false);
    add_display_options(app, output);
    app.add_option("--stats", output.stats, "Write statistics as JSON (docs/statistics.md)")
        ->type_name("FILE");
    app.add_option("--record-rays", output.record_rays,
                   "Write every traced ray, for `sightline compare --rays`")
        ->type_name("FILE");
}

void add_poses_options(CLI::App& app, PosesOptions& poses) {
    begin_group(app, "Layers");
    app.add_option("--poses", poses.path,
                   "Write the cameras of all pictures as JSON (docs/data_sets.md)")
        ->type_name("FILE")
        ->excludes(app.get_option("--render-part"));
    add_choice<PosesForm>(app, "--poses-form", poses.form,
                          "Form of --poses; nerfstudio: transforms.json, also of instant-ngp; "
                          "blender: the same without the endings of names, of NeRF and Gaussian "
                          "splatting",
                          {{"sightline", PosesForm::sightline},
                           {"nerfstudio", PosesForm::nerfstudio},
                           {"blender", PosesForm::blender}});
}

void add_format_option(CLI::App& app, std::string& format) {
    app.add_option("--format", format, "Format of what is written to standard output by -o -")
        ->type_name("NAME")
        ->check(one_of({"png", "exr", "jpg", "tif", "webp", "hdr", "mp4", "webm", "gif"}))
        ->default_str(format);
}

void add_resume_options(CLI::App& app, RunOptions& run) {
    begin_group(app, "Resume and parts");
    CLI::Option* resume = app.add_flag("--resume", run.resume,
                                       "Keep finished tiles in FILE.tiles beside the first picture "
                                       "until all pictures are written, "
                                       "and use those that an earlier run left there; of films, "
                                       "use the frames that it left in FILE.frames");
    CLI::Option* part =
        add_parsed(app, "--render-part", "I/N",
                   "Render part I of N, every Nth tile, into FILE.tiles and write no picture",
                   [&run](const std::string& text) { run.part = parse_part(text); });
    CLI::Option* merge = app.add_flag("--merge-parts", run.merge_parts,
                                      "Write the pictures from FILE.tiles once all parts exist");
    merge->excludes(part)->excludes(resume);
    part->excludes(resume);
    // Kept tiles have no record of their rays.
    app.get_option("--record-rays")->excludes(resume)->excludes(part)->excludes(merge);
}

void add_views_options(CLI::App& app, RenderCli& cli) {
    begin_group(app, "Several pictures");
    CLI::Option* views = add_views_option(app, cli.views);
    views->default_str("one, by --camera");
    CLI::Option* turntable = add_turntable_option(app, cli.turntable);
    CLI::Option* frames = add_frames_options(app, cli.frames);
    frames->excludes(app.get_option("--time"));
    for (const char* other : {"--camera", "--look-from", "--look-at"})
        views->excludes(app.get_option(other));
    for (const char* other : {"--render-part", "--merge-parts"})
        for (CLI::Option* several : {views, turntable, frames})
            several->excludes(app.get_option(other));
}

bool is_sequence(const RenderCli& cli) { return cli.turntable.count || !cli.frames.range.empty(); }

bool is_template(const RenderCli& cli) { return !cli.views.empty() || is_sequence(cli); }

std::string stem_of(const std::string& asset) {
    return asset == standard_input ? "stdin" : fs::path(asset).stem().string();
}

/// The command of one picture; its metadata has the command that renders it alone.
RenderCommand command_of(const RenderCommand& all, const PictureRequest& picture) {
    RenderCommand command = parse_settings(all.asset, picture.settings);
    const NameFields fields = name_fields(all.asset, stem_of(all.asset), picture);
    OutputOptions& output = command.output;
    for (const std::string& name : all.output.pictures)
        output.pictures.push_back(fill_in(name, fields));
    output.stats = fill_in(all.output.stats, fields);
    output.record_rays = fill_in(all.output.record_rays, fields);
    Task task;
    task.asset = all.asset;
    task.settings = picture.settings;
    task.outputs = output.pictures;
    if (!output.pictures.empty())
        std::ranges::copy(data_paths(output.pictures[0], output.data),
                          std::back_inserter(task.outputs));
    output.command = render_command(task);
    command.run = all.run;
    return command;
}

RenderSpec spec_of(const RenderCli& cli) {
    RenderSpec spec;
    spec.settings = given_settings(cli.settings);
    spec.views = make_views(cli.views);
    spec.use_file_cameras = true;
    spec.turntable = cli.turntable;
    spec.frames = cli.frames.frames();
    return spec;
}

/// Throws NameError if the names of the outputs do not differ, or if a film is to be made of
/// nothing.
void check_names_of(RenderSpec spec, const OutputOptions& output,
                    const std::vector<std::string>& movies) {
    for (const std::string& file : files_of(output)) {
        spec.name = file;
        check_template(spec);
    }
    spec.turntable.count = 0;
    spec.frames.reset();
    for (const std::string& movie : movies) {
        if (has_field(movie, "frame"))
            throw NameError(movie + ": a film has all frames; leave {frame} out of its name");
        spec.name = movie;
        check_template(spec);
    }
}

/// One command for each picture. Throws NameError if their names do not differ.
RenderPlan plan_of(const RenderCli& cli) {
    RenderCommand all = cli.command;
    std::vector<std::string> movies = take_movies(all.output.pictures, is_sequence(cli));
    if (!movies.empty() && !is_sequence(cli))
        throw NameError(movies[0] +
                        ": a film needs --turntable N or --frames FIRST..LAST; a picture ends "
                        "with .exr .png .jpg .tif .webp or .hdr");
    RenderPlan plan;
    plan.poses = cli.poses;
    if (!is_template(cli)) {
        plan.commands = {all};
        if (!plan.poses.path.empty()) plan.commands[0].output.destinations = {plan.poses.path};
        plan.posed.resize(1);
        return plan;
    }
    const RenderSpec spec = spec_of(cli);
    check_names_of(spec, all.output, movies);
    const bool only_movies = files_of(all.output).empty();
    if (all.output.pictures.empty() && (!cli.poses.path.empty() || !all.output.data.empty()))
        throw NameError(
            "--poses and --data are of pictures; write them, too, as with -o a_{frame:04}.png");
    if (all.run.resume && !only_movies)
        throw NameError(
            "--resume continues one picture, or films alone; it cannot be combined with the "
            "several pictures of --views, --turntable or --frames");
    all.run.resume = false;
    plan.movies = {std::move(movies), cli.frames.fps, cli.command.run.resume};
    plan.only_movies = only_movies;
    plan.several = true;
    std::vector<PictureRequest> pictures = pictures_of(spec);
    // Each time is loaded once, for all views.
    if (spec.frames) std::ranges::stable_sort(pictures, {}, &PictureRequest::frame);
    std::vector<std::string> outputs;
    for (const PictureRequest& picture : pictures) {
        RenderCommand& command = plan.commands.emplace_back(command_of(all, picture));
        std::ranges::move(files_of(command.output), std::back_inserter(outputs));
        PosedPicture& posed = plan.posed.emplace_back();
        posed.view = picture.view;
        posed.frame = picture.frame;
        if (!plan.movies.empty())
            plan.movies.add(command, picture.settings,
                            name_fields(all.asset, stem_of(all.asset), picture));
    }
    std::ranges::move(plan.movies.paths(), std::back_inserter(outputs));
    // So that an output that is an input is found before the first picture is written.
    if (!plan.poses.path.empty()) outputs.push_back(plan.poses.path);
    plan.commands[0].output.destinations = outputs;
    return plan;
}

/// Throws CLI::ValidationError if two outputs are one file.
void check_distinct(const RenderPlan& plan) {
    std::set<fs::path> paths;
    const auto add = [&](const std::vector<std::string>& files) {
        for (const std::string& file : files)
            if (!paths.insert(fs::absolute(file).lexically_normal()).second)
                throw CLI::ValidationError(fmt::format("{} is given as output twice", file));
    };
    for (const RenderCommand& command : plan.commands) add(files_of(command.output));
    add(plan.movies.paths());
    if (!plan.poses.path.empty()) add({plan.poses.path});
}

void check_plan(const RenderCli& cli, RenderPlan& plan) {
    check_distinct(plan);
    if (const std::string problem =
            alpha_problem(cli.command.light, plan.commands[0].output.pictures);
        !problem.empty())
        throw CLI::ValidationError(problem);
    if (!cli.poses.path.empty()) check_place(cli.poses.path);
    if (cli.poses.form != PosesForm::sightline && cli.command.view.ortho)
        throw CLI::ValidationError(
            "transforms.json has no orthographic cameras; leave out --ortho, or use --poses-form "
            "sightline");
    plan.movies.check();
    for (size_t i = 0; i < plan.commands.size(); ++i) {
        RenderCommand& command = plan.commands[i];
        check_outputs(command);
        if (is_template(cli))
            command.run.name = {
                plan.only_movies ? plan.movies.describe(i) : command.output.pictures[0], i + 1,
                plan.commands.size()};
    }
}

/// Throws CLI::ValidationError if standard output cannot take what it is to take.
void take_standard_output(RenderCli& cli) {
    const RunOptions& r = cli.command.run;
    cli.standard_output.take(cli.command.output.pictures, cli.format);
    if (!cli.standard_output.is_used()) return;
    cli.report.names = false;
    if (!cli.views.empty() || (is_sequence(cli) && !can_be_movie("film." + cli.format)))
        throw CLI::ValidationError(
            "standard output takes one picture, or one film with --format mp4, webm, gif or webp");
    if (r.resume || r.part || r.merge_parts)
        throw CLI::ValidationError(
            "--resume, --render-part and --merge-parts keep files beside the picture; give it a "
            "name instead of -");
    if (!cli.poses.path.empty() || !cli.command.output.data.empty())
        throw CLI::ValidationError(
            "--poses and --data name the picture's file; give it a name instead of -");
    if (cli.report.explain)
        throw CLI::ValidationError("--explain needs standard output for itself");
}

void run(RenderCli& cli) {
    cli.command.run.show_progress = !cli.report.quiet;
    take_standard_output(cli);
    const auto make_plan = [&] {
        try {
            return plan_of(cli);
        } catch (const NameError& e) {
            throw CLI::ValidationError(e.what());
        }
    };
    RenderPlan plan = make_plan();
    const std::stop_source interrupt = stop_on_signals(stop_limit);
    check_plan(cli, plan);
    run_plan(plan, cli.report, interrupt.get_token());
    if (cli.standard_output.is_used()) cli.standard_output.send();
}

}  // namespace

void add_render_command(CLI::App& app, const std::string& command_line) {
    const auto cli = std::make_shared<RenderCli>();
    RenderCommand& command = cli->command;
    command.output.command = command_line;
    CLI::App* sub = app.add_subcommand("render", "Render a glTF file to pictures");
    add_scene_argument(*sub, command.asset);
    add_ray_options(*sub, command);
    add_output_options(*sub, command.output);
    add_format_option(*sub, cli->format);
    add_layer_options(*sub, command);
    add_resume_options(*sub, command.run);
    add_poses_options(*sub, cli->poses);
    add_views_options(*sub, *cli);
    add_performance_options(*sub, command);
    begin_group(*sub, "Other");
    sub->add_flag("--explain", cli->report.explain,
                  "Print which features the scene needs and what that saves");
    add_progress_option(*sub);
    sub->add_flag("--quiet", cli->report.quiet, "Print no progress and no summary");
    cli->settings = setting_options(*sub);
    sub->footer("Try `sightline render asset.glb -o picture.png --size 800x600`.");
    sub->callback([cli] { run(*cli); });
}

}  // namespace sightline
