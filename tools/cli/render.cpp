#include "commands.h"
#include "core/error.h"
#include "core/files.h"
#include "core/message.h"
#include "core/text.h"
#include "interrupt.h"
#include "options.h"
#include "output/formats.h"
#include "output/output_set.h"
#include "output/statistics.h"

#include <chrono>
#include <filesystem>
#include <memory>
#include <set>

namespace sightline {
namespace {

struct RenderCli {
    RenderCommand command;
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
                   "Picture to write, .exr .png .jpg .tif .webp or .hdr; may be repeated")
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

/// Throws CLI::ValidationError if two outputs are one file.
void check_distinct(const OutputOptions& output) {
    std::vector<std::string> files = output.pictures;
    files.insert(files.end(), {output.stats, output.record_rays});
    std::set<std::filesystem::path> paths;
    for (const std::string& file : files)
        if (!file.empty() &&
            !paths.insert(std::filesystem::absolute(file).lexically_normal()).second)
            throw CLI::ValidationError(fmt::format("{} is given as output twice", file));
}

void run(RenderCli& cli) {
    RenderCommand& command = cli.command;
    check_distinct(command.output);
    if (const std::string problem = alpha_problem(command.light, command.output.pictures);
        !problem.empty())
        throw CLI::ValidationError(problem);
    const std::stop_source interrupt = stop_on_signals(stop_limit);
    command.run.show_progress = !cli.quiet;
    const AssetResult result = render_asset(command, interrupt.get_token());
    for (const std::string& warning : result.warnings)
        print_message("warning: {}\n", printable(command.asset + ": " + warning));
    if (!command.output.stats.empty())
        write_text(command.output.stats, statistics_json(command, result));
    if (cli.explain) print_explanation(result.needs);
    if (!cli.quiet) print_summary(command, result);
    if (result.interrupted) {
        const RunOptions& r = command.run;
        const bool kept = r.resume || r.merge_parts || r.part;
        throw Error(
            fmt::format("{}: interrupted; {} of {} tiles are {}", command.asset,
                        result.picture.tiles_done, result.picture.tiles,
                        kept ? "kept; repeat the command to continue"
                             : "in " + partial_path(command.output.pictures[0]) +
                                   "; with --resume, a render continues where it was interrupted"));
    }
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
    add_performance_options(*sub, command);
    begin_group(*sub, "Other");
    sub->add_flag("--explain", cli->explain,
                  "Print which features the scene needs and what that saves");
    sub->add_flag("--quiet", cli->quiet, "Print no progress and no summary");
    sub->footer("Try `sightline render asset.glb -o picture.png --size 800x600`.");
    sub->callback([cli] { run(*cli); });
}

}  // namespace sightline
