#include "batch/batch.h"
#include "batch/contact_sheet.h"
#include "batch/farm.h"
#include "batch/inputs.h"
#include "batch/manifest.h"
#include "batch/plan.h"
#include "batch/worker.h"
#include "core/error.h"
#include "core/text.h"
#include "options.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <memory>
#include <thread>

namespace sightline {
namespace {

namespace fs = std::filesystem;

struct BatchCommand {
    AssetOptions render;                      // checks render's options as they are parsed
    std::vector<const CLI::Option*> options;  // of render, to take over what was given
    std::vector<std::string> inputs, views, formats;
    std::string out, manifest, frames, name, log, compare_to;
    double fps = 24, timeout = 3600, grace = 20;
    int turntable = 0;
    unsigned jobs = 0;
    uint64_t memory_mib = 0;
    std::string farm;
    FarmOptions farm_options;
    bool dry_run = false, wait = false;
    bool all_cameras = false, resume = false, fail_on_change = false, quiet = false;
};

std::atomic<int> interrupts{0};

std::string long_name(const CLI::Option& option) {
    return option.get_lnames().empty() ? "" : option.get_lnames()[0];
}

// Options that say how to render, not what: a batch decides itself.
bool is_setting(const CLI::Option& option) {
    const std::string name = long_name(option);
    return !name.empty() && name != "help" && name != "threads";
}

std::set<std::string> names_of(const std::vector<const CLI::Option*>& options) {
    std::set<std::string> names;
    for (const CLI::Option* option : options)
        if (is_setting(*option)) names.insert(long_name(*option));
    return names;
}

Settings given_settings(const std::vector<const CLI::Option*>& options) {
    Settings settings;
    for (const CLI::Option* option : options) {
        if (!is_setting(*option) || option->count() == 0) continue;
        std::string& value = settings[long_name(*option)];
        if (option->get_expected_max() == 0) continue;  // a flag
        for (const std::string& part : option->results())
            value += (value.empty() ? "" : ",") + part;
    }
    if (const auto env = settings.find("env"); env != settings.end())
        env->second = absolute_environment(env->second, fs::current_path().string());
    return settings;
}

AssetOptions parse_settings(const std::string& asset, const Settings& settings) {
    AssetOptions options;
    CLI::App app;
    add_scene_options(app, options);
    add_picture_options(app, options);
    std::vector<std::string> arguments;
    for (const auto& [name, value] : settings)
        arguments.push_back("--" + name + (value.empty() ? "" : "=" + value));
    try {
        app.parse(arguments);
    } catch (const CLI::ParseError& e) {
        throw Error(asset + ": " + e.what());
    }
    options.path = asset;
    return options;
}

RenderSpec make_spec(const BatchCommand& command) {
    RenderSpec spec;
    spec.settings = given_settings(command.options);
    for (const std::string& view : command.views) spec.views.push_back(camera_view(view));
    spec.all_cameras = command.all_cameras;
    spec.turntable = command.turntable;
    if (!command.frames.empty()) spec.frames = parse_frames(command.frames, command.fps);
    spec.name = command.name;
    if (!command.formats.empty()) spec.formats = command.formats;
    return spec;
}

std::vector<AssetRequest> find_requests(const BatchCommand& command, const BatchRun& run) {
    const RenderSpec spec = make_spec(command);
    std::vector<AssetRequest> requests;
    for (const std::string& input : command.inputs)
        std::ranges::move(find_assets(input, spec), std::back_inserter(requests));
    if (!command.manifest.empty())
        std::ranges::move(read_manifest(command.manifest, spec, names_of(command.options)),
                          std::back_inserter(requests));
    std::vector<Task> assets;
    for (const AssetRequest& request : requests)
        if (request.spec.all_cameras)
            assets.push_back({request.asset, request.name, "", request.spec.settings, {}});
    const std::vector<size_t> cameras = count_cameras(assets, run);
    for (size_t i = 0, k = 0; i < requests.size(); ++i)
        if (requests[i].spec.all_cameras) requests[i].cameras = cameras[k++];
    return requests;
}

// Settles every name and every option before anything is rendered.
std::vector<PlannedTask> plan(const BatchCommand& command, const BatchRun& run) {
    std::vector<PlannedTask> planned;
    for (Task& task : make_tasks(find_requests(command, run))) {
        const AssetOptions options = parse_settings(task.asset, task.settings);
        const double pixels = static_cast<double>(options.width) * options.height;
        const double work = pixels * (options.error > 0 ? options.max_samples : options.samples);
        planned.push_back({std::move(task), work, pixels});
    }
    return planned;
}

BatchRun run_of(const BatchCommand& command) {
    BatchRun run;
    fs::create_directories(command.out);
    run.folder = fs::canonical(command.out).string();
    run.worker = worker_command(fs::read_symlink("/proc/self/exe").string(), command.memory_mib);
    run.threads = command.render.threads ? command.render.threads
                                         : std::max(1u, std::thread::hardware_concurrency());
    run.jobs = command.jobs ? command.jobs : run.threads;
    run.timeout = command.timeout;
    run.grace = command.grace;
    run.log = command.log;
    if (!command.compare_to.empty()) run.compare_to = fs::canonical(command.compare_to).string();
    run.show_progress = !command.quiet;
    run.interrupts = &interrupts;
    return run;
}

void run_on_farm(const BatchCommand& command, const BatchRun& run,
                 const std::vector<PlannedTask>& planned) {
    FarmOptions options = command.farm_options;
    options.program = run.worker.program;
    options.memory_mib = command.memory_mib;
    options.fail_on_change = command.fail_on_change;
    const FarmPlan plan = plan_farm(planned, run, options);
    if (command.dry_run) {
        fmt::print("# {} pictures in an array of {}, each element:\n{}\n# When all have ended:\n{}",
                   planned.size(), plan.groups.size(), plan.array_script, plan.merge_script);
        return;
    }
    {
        // Refuses a folder that is in use or holds an earlier batch.
        const Journal journal((fs::path(run.folder) / "journal.jsonl").string(), command.resume);
        write_farm(plan);
    }
    std::vector<size_t> groups(plan.groups.size());
    for (size_t i = 0; i < groups.size(); ++i) groups[i] = i;
    fmt::print("{}\n", submit_farm(plan.farm, groups));
    std::fflush(stdout);
    if (!command.wait) return;
    const int status = wait_for_farm(run.folder, interrupts);
    if (status != 0) throw CLI::RuntimeError(status);
}

// Throws what makes the program end with 3, or as the machine's fault, where that is so.
void conclude(const BatchCommand& command, const BatchResult& result, size_t tasks) {
    const auto count = [&](auto test) {
        return static_cast<size_t>(std::ranges::count_if(result.outcomes, test));
    };
    const size_t failed = count([](const Outcome& o) { return o.verdict != TaskVerdict::ok; });
    const size_t skipped = count([](const Outcome& o) { return o.skipped; });
    const size_t changed = count([](const Outcome& o) { return is_different(o.change); });
    if (!command.quiet)
        fmt::print(stderr,
                   "{} pictures in {:.1f} s: {} rendered, {} unchanged since before, "
                   "{} failed{}\n{}/index.html\n",
                   result.outcomes.size(), result.seconds,
                   result.outcomes.size() - failed - skipped, skipped, failed,
                   command.compare_to.empty() ? "" : fmt::format(", {} changed", changed),
                   printable(command.out));
    if (result.interrupted)
        throw Error(fmt::format("interrupted after {} of {} pictures; continue with --resume",
                                result.outcomes.size(), tasks));
    if (failed || (changed && command.fail_on_change)) throw CLI::RuntimeError(3);
}

void run_command(const BatchCommand& command) {
    if (command.inputs.empty() && command.manifest.empty())
        throw CLI::RequiredError("an INPUT or --manifest");
    for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { ++interrupts; });
    const BatchRun run = run_of(command);
    const std::vector<PlannedTask> planned = plan(command, run);
    if (!command.farm.empty()) return run_on_farm(command, run, planned);
    Journal journal((fs::path(run.folder) / "journal.jsonl").string(), command.resume);
    remove_leftovers(planned, run.folder);
    const BatchResult result = run_batch(planned, run, journal);
    remove_leftovers(planned, run.folder);  // of workers that were killed
    std::vector<Task> tasks;
    for (const PlannedTask& task : planned) tasks.push_back(task.task);
    write_contact_sheet(run.folder, tasks, result.outcomes, run.compare_to);
    conclude(command, result, tasks.size());
}

void add_plan_options(CLI::App& app, BatchCommand& c) {
    app.add_option("INPUT", c.inputs, "Assets: files, folders with all below them, 'patterns*'")
        ->type_name("FILE|DIR|PATTERN");
    app.add_option("--manifest", c.manifest,
                   "Assets with options of their own "
                   "(docs/batch.md)")
        ->type_name("FILE.json");
    app.add_option("--name", c.name,
                   "Names of the pictures, of {asset} {stem} {ext} {view} "
                   "{frame:04} {variant} (default: what tells them apart)")
        ->type_name("TEMPLATE");
    app.add_option("--format", c.formats, "Endings of the pictures [png]")
        ->delimiter(',')
        ->check(CLI::IsMember({"exr", "png", "jpg", "tif", "webp", "hdr"}));
    app.add_option("--views", c.views,
                   "Several views: cameras by name or index, fit, front, back, "
                   "left, right, top, bottom")
        ->delimiter(',');
    app.add_flag("--all-cameras", c.all_cameras, "A view for each camera of the file");
    app.add_option("--turntable", c.turntable, "So many pictures once around the asset")
        ->check(CLI::Range(1, 100'000));
    app.add_option("--frames", c.frames, "Frames of the animation")->type_name("FIRST..LAST");
    app.add_option("--fps", c.fps, "Frames a second")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
}

void add_run_options(CLI::App& app, BatchCommand& c) {
    app.add_option("--out", c.out, "Folder of the pictures")->required()->type_name("DIR");
    app.add_flag("--resume", c.resume, "Go on where an earlier run of this batch ended");
    app.add_option("--jobs", c.jobs, "Workers side by side (default: as many as threads)")
        ->check(CLI::Range(1, 4096));
    app.add_option("--timeout", c.timeout, "Seconds a picture may take, 0 for any")
        ->capture_default_str()
        ->check(CLI::NonNegativeNumber);
    app.add_option("--memory", c.memory_mib, "Memory a worker may take (default: any)")
        ->type_name("MIB");
    app.add_option("--grace", c.grace, "Seconds to finish what is begun after SIGTERM or Ctrl-C")
        ->capture_default_str()
        ->check(CLI::NonNegativeNumber);
    app.add_option("--log", c.log, "Append a JSON line per event")->type_name("FILE");
    app.add_option("--compare-to", c.compare_to, "Mark what changed against an earlier batch")
        ->type_name("DIR")
        ->check(CLI::ExistingDirectory);
    app.add_flag("--fail-on-change", c.fail_on_change,
                 "Exit with 3 where a picture differs from --compare-to");
    app.add_flag("--quiet", c.quiet, "No progress and no summary");
}

void add_farm_options(CLI::App& app, BatchCommand& c) {
    FarmOptions& f = c.farm_options;
    auto* farm = app.add_option("--farm", c.farm, "Render on a cluster (docs/farm.md)")
                     ->check(CLI::IsMember({"slurm"}));
    app.add_flag("--dry-run", c.dry_run, "Print what would be submitted")->needs(farm);
    app.add_flag("--wait", c.wait, "Wait for the farm, and end with its status")->needs(farm);
    app.add_option("--farm-option", f.sbatch_options,
                   "Option for sbatch, such as --partition=short")
        ->needs(farm)
        ->allow_extra_args(false);
    app.add_option("--farm-seconds", f.group_seconds, "What one element of the array should take")
        ->needs(farm)
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
    app.add_option("--farm-elements", f.max_groups, "Most elements of the array")
        ->needs(farm)
        ->capture_default_str()
        ->check(CLI::Range(1, 1'000'000));
    app.add_option("--farm-at-once", f.max_running, "Most elements that run at once")->needs(farm);
    app.add_option("--farm-attempts", f.max_attempts, "How often what is missing is submitted")
        ->needs(farm)
        ->capture_default_str()
        ->check(CLI::Range(1, 100));
}

}  // namespace

void add_batch_command(CLI::App& app) {
    const auto command = std::make_shared<BatchCommand>();
    CLI::App* sub =
        app.add_subcommand("batch", "Render many assets, each in a process of its own, unattended");
    add_scene_options(*sub, command->render);
    add_picture_options(*sub, command->render);
    const CLI::App& constant = *sub;
    command->options = constant.get_options();
    add_plan_options(*sub, *command);
    add_run_options(*sub, *command);
    add_farm_options(*sub, *command);
    sub->callback([command] { run_command(*command); });
}

void add_worker_command(CLI::App& app) {
    const auto memory_mib = std::make_shared<uint64_t>(0);
    const auto parent = std::make_shared<int>(0);
    CLI::App* sub = app.add_subcommand("worker", "What `batch` starts");
    sub->group("");  // not for people
    sub->add_option("--memory", *memory_mib);
    sub->add_option("--parent", *parent)->required();
    sub->callback([memory_mib, parent] {
        if (const int status = run_worker(parse_settings, *parent, *memory_mib))
            throw CLI::RuntimeError(status);
    });
}

}  // namespace sightline
