#include "batch/plan.h"
#include "commands.h"
#include "core/error.h"
#include "core/files.h"
#include "core/message.h"
#include "core/text.h"
#include "interrupt.h"
#include "output/formats.h"
#include "output/output_set.h"
#include "output/statistics.h"
#include "picture_options.h"

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
    bool explain = false, quiet = false;
};

/// What an interrupted render may take to write the tiles in flight; finished tiles that are kept
/// stay in any case.
constexpr auto stop_limit = std::chrono::milliseconds(1500);

void print_explanation(const Needs& needs) {
    for (const Decision& decision : needs.report) {
        fmt::print("{:<20} {:<8} {}{}\n", decision.name, decision.choice, decision.because,
                   decision.saves.empty() ? "" : "; saves " + decision.saves);
    }
}

// Which camera and which light the picture has, and why.
void print_choices(const Needs& needs) {
    std::string line;
    for (const Decision& decision : needs.report)
        if (decision.name == "camera" || decision.name == "light")
            line += fmt::format("{}{}: {} ({})", line.empty() ? "" : "; ", decision.name,
                                decision.choice, decision.because);
    print_message("{}\n", printable(line));
}

void print_summary(const RenderCommand& command, const AssetResult& result) {
    print_choices(result.needs);
    const StageTimes& s = result.seconds;
    for (const std::string& picture : command.output.pictures)
        if (!command.run.part && !result.interrupted) fmt::print("{}\n", picture);
    print_message("{:.2f} s: load {:.2f}, build {:.2f}, render {:.2f}, write {:.2f}\n", s.total,
                  s.load(), s.build + s.prepare, s.render, s.write);
}

PicturePart parse_part(const std::string& text) {
    PicturePart part;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%u/%u%c", &part.index, &part.count, &rest) != 2 ||
        part.index < 1 || part.index > part.count)
        throw std::invalid_argument(fmt::format("'{}' is not a part I/N such as 1/8", text));
    --part.index;
    return part;
}

void add_output_options(CLI::App& app, OutputOptions& output) {
    begin_group(app, "Output");
    app.add_option("-o,--output", output.pictures,
                   "Picture to write, .exr .png .jpg .tif .webp or .hdr; may be repeated; with "
                   "--views a template such as a_{view}.png, with --turntable a_{frame:04}.png")
        ->required()
        ->type_name("FILE")
        ->check(CLI::Validator(format_problem, {}))
        ->allow_extra_args(false);
    add_display_options(app, output);
    app.add_option("--stats", output.stats, "Write statistics as JSON (docs/statistics.md)")
        ->type_name("FILE");
    app.add_option("--record-rays", output.record_rays,
                   "Write every traced ray, for `sightline compare --rays`")
        ->type_name("FILE");
}

void add_resume_options(CLI::App& app, RunOptions& run) {
    begin_group(app, "Resume and parts");
    CLI::Option* resume = app.add_flag("--resume", run.resume,
                                       "Keep finished tiles in FILE.tiles beside the first picture "
                                       "until all pictures are written, "
                                       "and use those that an earlier run left there");
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
    for (const char* other : {"--camera", "--look-from", "--look-at"})
        views->excludes(app.get_option(other));
    for (const char* other : {"--resume", "--render-part", "--merge-parts"})
        views->excludes(app.get_option(other)), turntable->excludes(app.get_option(other));
}

bool is_template(const RenderCli& cli) { return !cli.views.empty() || cli.turntable.count; }

std::vector<std::string> outputs_of(const OutputOptions& output) {
    std::vector<std::string> files = output.pictures;
    for (const std::string& file : {output.stats, output.record_rays})
        if (!file.empty()) files.push_back(file);
    return files;
}

/// The command of one picture; its metadata has the command that renders it alone.
RenderCommand command_of(const RenderCommand& all, const PictureRequest& picture) {
    RenderCommand command = parse_settings(all.asset, picture.settings);
    const NameFields fields = name_fields(all.asset, fs::path(all.asset).stem(), picture);
    OutputOptions& output = command.output;
    for (const std::string& name : all.output.pictures)
        output.pictures.push_back(fill_in(name, fields));
    output.stats = fill_in(all.output.stats, fields);
    output.record_rays = fill_in(all.output.record_rays, fields);
    Task task;
    task.asset = all.asset;
    task.settings = picture.settings;
    task.outputs = output.pictures;
    output.command = render_command(task);
    command.run = all.run;
    return command;
}

/// One command for each picture. Throws NameError if their names do not differ.
std::vector<RenderCommand> commands_of(const RenderCli& cli) {
    if (!is_template(cli)) return {cli.command};
    RenderSpec spec;
    spec.settings = given_settings(cli.settings);
    spec.views = make_views(cli.views);
    spec.use_file_cameras = true;
    spec.turntable = cli.turntable;
    for (const std::string& file : outputs_of(cli.command.output)) {
        spec.name = file;
        check_template(spec);
    }
    std::vector<RenderCommand> commands;
    std::vector<std::string> outputs;
    for (const PictureRequest& picture : pictures_of(spec)) {
        commands.push_back(command_of(cli.command, picture));
        std::ranges::move(outputs_of(commands.back().output), std::back_inserter(outputs));
    }
    // So that an output that is an input is found before the first picture is written.
    commands[0].output.destinations = outputs;
    return commands;
}

/// Throws CLI::ValidationError if two outputs are one file.
void check_distinct(const std::vector<RenderCommand>& commands) {
    std::set<fs::path> paths;
    for (const RenderCommand& command : commands)
        for (const std::string& file : outputs_of(command.output))
            if (!paths.insert(fs::absolute(file).lexically_normal()).second)
                throw CLI::ValidationError(fmt::format("{} is given as output twice", file));
}

std::string describe_interruption(const RenderCli& cli, const RenderCommand& command,
                                  const AssetResult& result) {
    const RunOptions& r = command.run;
    std::string where = "kept; repeat the command to continue";
    if (!r.resume && !r.merge_parts && !r.part) {
        where = "in " + partial_path(command.output.pictures[0]);
        if (!is_template(cli))
            where += "; with --resume, a render continues where it was interrupted";
    }
    return fmt::format("{}: interrupted; {} of {} tiles are {}", command.asset,
                       result.picture.tiles_done, result.picture.tiles, where);
}

/// Prints and writes what there is to say of a picture, except a warning that an earlier one had.
void report(const RenderCli& cli, const RenderCommand& command, const AssetResult& result,
            std::set<std::string>& warned) {
    const bool is_blank = result.content != PictureContent::something;
    for (const std::string& warning : result.warnings) {
        std::string place = command.asset;
        if (is_template(cli) && is_blank && &warning == &result.warnings.back())
            place += ": " + command.output.pictures[0];
        const std::string line = printable(place + ": " + warning);
        if (warned.insert(line).second) print_message("warning: {}\n", line);
    }
    if (!command.output.stats.empty())
        write_text(command.output.stats, statistics_json(command, result));
    if (cli.explain) print_explanation(result.needs);
    if (!cli.quiet) print_summary(command, result);
}

/// Renders the pictures one after the other from one asset in memory. Throws Error.
void render_all(const RenderCli& cli, const std::vector<RenderCommand>& commands,
                const std::stop_token& stop) {
    const size_t count = commands.size();
    const auto pictures = count > 1 ? Asset::Pictures::several : Asset::Pictures::one;
    Asset asset(commands[0], pictures);
    for (const RenderCommand& command : commands) asset.check_camera(command);
    std::set<std::string> warned;
    for (size_t i = 0; i < count; ++i) {
        const RenderCommand& command = commands[i];
        const std::string done = fmt::format("; {} of {} pictures are finished", i, count);
        if (i > 0 && stop.stop_requested()) throw Error(command.asset + ": interrupted" + done);
        try {
            const AssetResult result = asset.render(command, stop);
            report(cli, command, result, warned);
            if (result.interrupted) throw Error(describe_interruption(cli, command, result));
        } catch (const Error& e) {
            if (count == 1 || !stop.stop_requested()) throw;
            throw Error(e.what() + done);
        }
    }
}

void run(RenderCli& cli) {
    cli.command.run.show_progress = !cli.quiet;
    std::vector<RenderCommand> commands;
    try {
        commands = commands_of(cli);
    } catch (const NameError& e) {
        throw CLI::ValidationError(e.what());
    }
    check_distinct(commands);
    if (const std::string problem = alpha_problem(cli.command.light, cli.command.output.pictures);
        !problem.empty())
        throw CLI::ValidationError(problem);
    const std::stop_source interrupt = stop_on_signals(stop_limit);
    for (size_t i = 0; i < commands.size(); ++i) {
        check_outputs(commands[i]);
        if (is_template(cli))
            commands[i].run.label = fmt::format(
                "{} ({} of {})", printable(commands[i].output.pictures[0]), i + 1, commands.size());
    }
    render_all(cli, commands, interrupt.get_token());
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
    add_layer_options(*sub, command);
    add_resume_options(*sub, command.run);
    add_views_options(*sub, *cli);
    add_performance_options(*sub, command);
    begin_group(*sub, "Other");
    sub->add_flag("--explain", cli->explain,
                  "Print which features the scene needs and what that saves");
    sub->add_flag("--quiet", cli->quiet, "Print no progress and no summary");
    cli->settings = setting_options(*sub);
    sub->footer("Try `sightline render asset.glb -o picture.png --size 800x600`.");
    sub->callback([cli] { run(*cli); });
}

}  // namespace sightline
