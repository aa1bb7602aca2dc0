#include "options.h"

#include "core/error.h"
#include "core/files.h"
#include "core/text.h"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <memory>
#include <set>
#include <thread>

namespace sightline {
namespace {

struct RenderCommand {
    AssetOptions options;
    bool explain = false, quiet = false;
};

/// Turns the first SIGINT or SIGTERM into a request to stop after the tiles in flight; the second
/// kills as usual. To be called before other threads start, so that all of them leave the signals
/// to the one that waits here.
std::stop_source stop_on_signals() {
    std::stop_source source;
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::thread([source, signals]() mutable {
        int signal = 0;
        sigwait(&signals, &signal);
        source.request_stop();
        pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
        while (true) pause();
    }).detach();
    return source;
}

void print_explanation(const AssetResult& result) {
    for (const Decision& decision : result.needs.report) {
        fmt::print("{:<18} {:<8} {}{}\n", decision.name, decision.choice, decision.because,
                   decision.saves.empty() ? "" : "; saves " + decision.saves);
    }
}

void print_summary(const AssetOptions& options, const AssetResult& result) {
    const StageTimes& s = result.seconds;
    for (const std::string& output : options.outputs)
        if (!options.part && !result.interrupted) fmt::print("{}\n", output);
    fmt::print(stderr, "{:.2f} s: load {:.2f}, build {:.2f}, render {:.2f}, write {:.2f}\n",
               s.total, s.load, s.build, s.render, s.write);
}

PicturePart parse_part(const std::string& text) {
    PicturePart part;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%u/%u%c", &part.index, &part.count, &rest) != 2 ||
        part.index < 1 || part.index > part.count)
        throw CLI::ValidationError(fmt::format("'{}' is not a part I/N such as 1/8", text));
    --part.index;
    return part;
}

void add_resume_options(CLI::App& app, AssetOptions& o) {
    auto* resume =
        app.add_flag("--resume", o.resume,
                     "Keep finished tiles in FILE.tiles beside the first output until all is "
                     "written, and go on from those that an earlier run has left there");
    auto* part = app.add_option_function<std::string>(
                        "--part", [&o](const std::string& s) { o.part = parse_part(s); },
                        "Render every Nth tile into FILE.tiles, from the Ith on, and no picture")
                     ->type_name("I/N");
    auto* join =
        app.add_flag("--join", o.join, "Write the pictures of which all parts have been rendered");
    join->excludes(part)->excludes(resume);
    part->excludes(resume);
    // Kept tiles do not tell their rays.
    app.get_option("--record-rays")->excludes(resume)->excludes(part)->excludes(join);
}

/// Throws where two files would be one.
void check_distinct(const AssetOptions& o) {
    std::vector<std::string> files = o.outputs;
    files.insert(files.end(), {o.stats, o.record_rays});
    std::set<std::filesystem::path> seen;
    for (const std::string& file : files)
        if (!file.empty() &&
            !seen.insert(std::filesystem::absolute(file).lexically_normal()).second)
            throw CLI::ValidationError(fmt::format("{} is to be written twice", file));
}

void run(RenderCommand& command) {
    check_distinct(command.options);
    const std::stop_source interrupt = stop_on_signals();
    command.options.show_progress = !command.quiet;
    const AssetResult result = render_asset(command.options, interrupt.get_token());
    for (const std::string& warning : result.warnings)
        fmt::print(stderr, "warning: {}\n", printable(command.options.path + ": " + warning));
    if (!command.options.stats.empty())
        write_text(command.options.stats, statistics_json(command.options, result));
    if (command.explain) print_explanation(result);
    if (!command.quiet) print_summary(command.options, result);
    if (result.interrupted) {
        const RenderResult& p = result.picture;
        const AssetOptions& o = command.options;
        const bool kept = o.resume || o.join || o.part;
        throw Error(fmt::format("{}: interrupted; the {} of {} tiles that were done are {}", o.path,
                                p.tiles_done, p.tiles,
                                kept ? "kept: run it again to go on" : "written"));
    }
}

}  // namespace

void add_render_command(CLI::App& app, const std::string& command_line) {
    const auto command = std::make_shared<RenderCommand>();
    AssetOptions& o = command->options;
    o.command = command_line;
    CLI::App* sub = app.add_subcommand("render", "Render a glTF asset to pictures");
    sub->add_option("SCENE", o.path, ".gltf or .glb file")->required()->type_name("FILE");
    sub->add_option("-o,--output", o.outputs,
                    "Picture to write: .exr .png .jpg .tif .webp .hdr (repeat for more)")
        ->required()
        ->type_name("FILE")
        ->check(CLI::Validator(format_problem, {}))
        ->allow_extra_args(false);
    add_scene_options(*sub, o);
    add_picture_options(*sub, o);
    sub->add_option("--stats", o.stats, "Write statistics")->type_name("FILE.json");
    sub->add_option("--record-rays", o.record_rays, "Write every ray that is traced")
        ->type_name("FILE");
    add_resume_options(*sub, o);
    sub->add_flag("--explain", command->explain, "Say what the scene needs and what that saves");
    sub->add_flag("--quiet", command->quiet, "No progress and no summary");
    sub->callback([command] { run(*command); });
}

}  // namespace sightline
