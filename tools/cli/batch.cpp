#include "batch/batch.h"
#include "batch/contact_sheet.h"
#include "batch/farm.h"
#include "batch/film_task.h"
#include "batch/inputs.h"
#include "batch/manifest.h"
#include "batch/plan.h"
#include "batch/report.h"
#include "batch/views.h"
#include "batch/worker.h"
#include "commands.h"
#include "core/error.h"
#include "core/file_clash.h"
#include "core/files.h"
#include "core/message.h"
#include "core/text.h"
#include "output/formats.h"
#include "output/movie.h"
#include "output/output_folder.h"
#include "picture_options.h"
#include "progress_option.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <memory>
#include <thread>

namespace sightline {
namespace {

namespace fs = std::filesystem;

struct BatchCli {
    RenderCommand render;                     // checks render's options as they are parsed
    std::vector<const CLI::Option*> options;  // those that are given go to the tasks
    std::vector<std::string> inputs, views, formats;
    std::string out, manifest, name, log, compare_to;
    double timeout = 3600, grace = 20;
    Ring turntable;
    FrameOptions frames;
    unsigned jobs = 0;
    uint64_t memory_mib = 0;
    std::string farm;
    FarmOptions farm_options;
    bool dry_run = false, wait = false;
    bool all_cameras = false, use_file_cameras = false, follow_links = false, resume = false,
         overwrite = false, fail_on_change = false;
    bool quiet = false;
};

std::atomic<int> interrupts{0};

RenderSpec make_spec(const BatchCli& cli) {
    RenderSpec spec;
    spec.settings = given_settings(cli.options);
    if (const auto env = spec.settings.find("env"); env != spec.settings.end())
        env->second = absolute_environment(env->second, fs::current_path().string());
    spec.views = make_views(cli.views);
    spec.all_cameras = cli.all_cameras;
    spec.use_file_cameras = cli.use_file_cameras;
    spec.turntable = cli.turntable;
    spec.frames = cli.frames.frames();
    spec.fps = cli.frames.fps;
    spec.name = cli.name;
    if (!cli.formats.empty()) spec.formats = cli.formats;
    return spec;
}

std::vector<AssetRequest> find_requests(const BatchCli& cli, const BatchRun& run,
                                        InputSearch& search) {
    const RenderSpec spec = make_spec(cli);
    check_names(spec);
    std::vector<AssetRequest> requests;
    for (const std::string& input : cli.inputs)
        std::ranges::move(find_assets(input, spec, search), std::back_inserter(requests));
    if (!cli.manifest.empty())
        std::ranges::move(read_manifest(cli.manifest, spec, names_of(cli.options), search),
                          std::back_inserter(requests));
    check_that_one_exists(requests, search);
    for (const std::string& asset : remove_repeated(requests))
        search.passed_over.push_back({asset, "is given more than once; it is rendered once"});
    std::vector<Task> assets;
    for (const AssetRequest& request : requests)
        if (request.spec.all_cameras)
            assets.push_back(
                {request.asset, request.name, request.name, "", request.spec.settings, {}});
    const auto cameras = list_cameras(assets, run);
    for (size_t i = 0, k = 0; i < requests.size(); ++i)
        if (requests[i].spec.all_cameras)
            if (const auto& names = cameras[k++]) requests[i].cameras = names->size();
    return requests;
}

struct BatchPlan {
    std::vector<PlannedTask> tasks;
    std::vector<PassedOver> passed_over;
};

// Throws NameError if the film's format cannot hold it; adds a name of each format to `formats`.
void check_film(const Task& task, const RenderCommand& command, std::set<std::string>& formats) {
    const MovieOptions options = movie_options(command, std::stod(task.film.at("fps")));
    for (const std::string& output : task.outputs) {
        if (const std::string problem = movie_problem(output, options); !problem.empty())
            throw NameError(problem);
        formats.insert("film" + extension_of(output));
    }
}

// Checks every name and every option before anything is rendered.
BatchPlan plan_tasks(const BatchCli& cli, const BatchRun& run) {
    InputSearch search{cli.follow_links, {}, ""};
    const auto requests = find_requests(cli, run, search);
    const fs::path journal = fs::path(run.folder) / journal_name;
    const KnownNames known = cli.resume ? read_names(journal.string()) : KnownNames();
    std::vector<PlannedTask> planned;
    std::set<std::string> films;
    for (Task& task : make_tasks(requests, known)) {
        const RenderCommand command = parse_settings(task.asset, task.settings);
        const size_t frames = task.film.empty() ? 1 : film_frames(task).size();
        if (!task.film.empty()) check_film(task, command, films);
        if (const std::string problem = alpha_problem(command.light, task.outputs);
            !problem.empty())
            throw NameError(problem);
        const RenderSettings& s = command.settings;
        const auto pictures = static_cast<double>(frames);
        const double pixels = static_cast<double>(s.width) * s.height * pictures;
        const double work = pixels * (s.error > 0 ? s.max_samples : s.samples);
        planned.push_back({std::move(task), work, pixels, pictures});
    }
    if (!films.empty()) check_ffmpeg(std::vector(films.begin(), films.end()));
    check_cameras(planned, run);
    return {std::move(planned), std::move(search.passed_over)};
}

// A name that cannot be given is the fault of the command line or, if there is one, the manifest.
BatchPlan plan(const BatchCli& cli, const BatchRun& run) {
    try {
        return plan_tasks(cli, run);
    } catch (const NameError& e) {
        if (!cli.manifest.empty()) throw;
        throw CLI::ValidationError(e.what());
    }
}

// Why the folder cannot be that of an earlier batch; "" if it can.
std::string existing_folder_problem(const std::string& path) {
    std::error_code error;
    return fs::is_directory(path, error) ? "" : fmt::format("there is no folder {}", path);
}

BatchRun run_of(const BatchCli& cli) {
    BatchRun run;
    run.folder = fs::weakly_canonical(cli.out).string();
    run.worker = worker_command(fs::read_symlink("/proc/self/exe").string(), cli.memory_mib);
    run.threads = cli.render.run.threads ? cli.render.run.threads
                                         : std::max(1u, std::thread::hardware_concurrency());
    run.jobs = cli.jobs ? cli.jobs : run.threads;
    run.timeout = cli.timeout;
    run.grace = cli.grace;
    run.log = cli.log;
    if (!cli.compare_to.empty()) run.compare_to = fs::canonical(cli.compare_to).string();
    run.show_progress = !cli.quiet;
    run.interrupts = &interrupts;
    return run;
}

/// Throws OutputIsInput if the batch would write to a file of its command line. What the assets
/// name is checked by the workers.
void check_inputs(const BatchCli& cli, const BatchRun& run,
                  const std::vector<PlannedTask>& planned) {
    std::vector<std::string> inputs = {cli.manifest}, outputs = {cli.log};
    for (const char* name : {journal_name, contact_sheet_name})
        outputs.push_back((fs::path(run.folder) / name).string());
    for (const PlannedTask& p : planned) {
        inputs.push_back(p.task.asset);
        if (const auto env = p.task.settings.find("env"); env != p.task.settings.end())
            inputs.push_back(env->second);
        for (const std::string& output : p.task.outputs)
            outputs.push_back((fs::path(run.folder) / output).string());
    }
    check_outputs_are_not_inputs(outputs, inputs);
}

/// Throws Error if the batch would replace a file that no batch made.
void claim_files(const BatchCli& cli, const BatchRun& run, const std::vector<PlannedTask>& planned,
                 const Journal& journal) {
    std::set<std::string> own;
    for (const auto& [key, outcome] : journal.outcomes())
        for (const FileHash& output : outcome.outputs) own.insert(output.path);
    if (!own.empty()) own.insert(contact_sheet_name);
    std::vector<std::string> names = {contact_sheet_name};
    for (const PlannedTask& p : planned)
        names.insert(names.end(), p.task.outputs.begin(), p.task.outputs.end());
    claim_outputs(run.folder, names, own, cli.overwrite);
}

void run_on_farm(const BatchCli& cli, const BatchRun& run, const BatchPlan& batch) {
    const std::vector<PlannedTask>& planned = batch.tasks;
    FarmOptions options = cli.farm_options;
    options.program = run.worker.program;
    options.memory_mib = cli.memory_mib;
    options.fail_on_change = cli.fail_on_change;
    const FarmPlan plan = plan_farm(planned, run, options);
    if (cli.dry_run) {
        fmt::print("# {} pictures in an array of {}, each element:\n{}\n# When all have ended:\n{}",
                   planned.size(), plan.groups.size(), plan.array_script, plan.merge_script);
        return;
    }
    {
        // Refuses a folder that is in use or holds an earlier batch.
        make_output_folder(run.folder, "--out");
        Journal journal((fs::path(run.folder) / journal_name).string(), cli.resume);
        claim_files(cli, run, planned, journal);
        journal.pass_over(batch.passed_over);
        write_farm(plan);
    }
    std::vector<size_t> groups(plan.groups.size());
    for (size_t i = 0; i < groups.size(); ++i) groups[i] = i;
    fmt::print("{}\n", submit_farm(plan.farm, groups));
    std::fflush(stdout);
    if (!cli.wait) return;
    const int status = wait_for_farm(run.folder, interrupts);
    if (status != 0) throw CLI::RuntimeError(status);
}

// A line about the inputs that are not rendered; empty if there are none.
std::string describe_passed_over(const BatchPlan& batch) {
    const size_t count = batch.passed_over.size();
    if (count == 0) return "";
    const PassedOver& first = batch.passed_over[0];
    return printable(fmt::format(
               "{} passed over: {}: {}{}", count == 1 ? "1 input" : fmt::format("{} inputs", count),
               first.path, first.reason, count > 1 ? "; journal.jsonl lists all" : "")) +
           "\n";
}

// Throws if the batch was interrupted, or, with exit code 3, if a picture failed or changed.
void print_summary(const BatchCli& cli, const BatchResult& result, const BatchPlan& batch) {
    const auto count = [&](auto test) {
        return static_cast<size_t>(std::ranges::count_if(result.outcomes, test));
    };
    const size_t failed = count([](const Outcome& o) { return !has_picture(o.verdict); });
    const size_t empty = count([](const Outcome& o) { return o.verdict == TaskVerdict::empty; });
    const size_t black = count([](const Outcome& o) { return o.verdict == TaskVerdict::black; });
    const size_t skipped = count([](const Outcome& o) { return o.skipped; });
    const size_t changed = count([](const Outcome& o) { return is_different(o.change); });
    if (!cli.quiet)
        print_message(
            "{} pictures in {:.1f} s: {} rendered, {} unchanged since an earlier run, "
            "{} failed{}{}{}\n{}{}/index.html\n",
            result.outcomes.size(), result.seconds, result.outcomes.size() - failed - skipped,
            skipped, failed, empty ? fmt::format(", {} empty", empty) : "",
            black ? fmt::format(", {} black", black) : "",
            cli.compare_to.empty() ? "" : fmt::format(", {} changed", changed),
            describe_stages(result.outcomes) + describe_warnings(result.outcomes) +
                describe_passed_over(batch),
            printable(cli.out));
    if (result.interrupted)
        throw Error(fmt::format("interrupted after {} of {} pictures; continue with --resume",
                                result.outcomes.size(), batch.tasks.size()));
    if (failed || (changed && cli.fail_on_change)) throw CLI::RuntimeError(3);
}

void run_command(const BatchCli& cli) {
    if (cli.inputs.empty() && cli.manifest.empty())
        throw CLI::ValidationError("an INPUT or --manifest FILE is required");
    for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { ++interrupts; });
    const BatchRun run = run_of(cli);
    const BatchPlan batch = plan(cli, run);
    const std::vector<PlannedTask>& planned = batch.tasks;
    check_inputs(cli, run, planned);
    if (!cli.farm.empty()) return run_on_farm(cli, run, batch);
    make_output_folder(run.folder, "--out");
    Journal journal((fs::path(run.folder) / journal_name).string(), cli.resume);
    claim_files(cli, run, planned, journal);
    journal.pass_over(batch.passed_over);
    remove_leftovers(planned, run.folder);
    const BatchResult result = run_batch(planned, run, journal);
    remove_leftovers(planned, run.folder);  // of workers that were killed
    std::vector<Task> tasks;
    for (const PlannedTask& task : planned) tasks.push_back(task.task);
    write_contact_sheet(run.folder, tasks, result.outcomes, run.compare_to);
    print_summary(cli, result, batch);
}

void add_input_options(CLI::App& app, BatchCli& c) {
    begin_group(app, "Input");
    app.add_option("INPUT", c.inputs,
                   "glTF file, folder to search with all below it, or 'pattern*'; may be repeated")
        ->type_name("FILE|DIR|PATTERN");
    app.add_option("--manifest", c.manifest,
                   "JSON file of assets with options of their own (docs/batch.md)")
        ->type_name("FILE");
    app.add_flag("--follow-links", c.follow_links,
                 "Follow links that lead out of the folder that is searched; by default they are "
                 "passed over");
}

void add_plan_options(CLI::App& app, BatchCli& c) {
    begin_group(app, "Pictures of each asset");
    app.add_option("--out", c.out, "Folder for the pictures")->required()->type_name("DIR");
    app.add_option(
           "--name", c.name,
           "Name of each picture: {asset} is the asset's path below the folder that is searched, "
           "{stem} its name alone, {ext} its ending, {view} the name of the view, {frame:04} the "
           "number of the frame or step of a turntable with four digits, {variant} the material "
           "variant, as in '{stem}/{view}_{frame:04}'")
        ->type_name("TEMPLATE")
        ->default_str("{asset}, with _{view} and _{frame:04} if there are several");
    app.add_option(
           "--format", c.formats,
           "Formats of each picture, or of films of --turntable or --frames, mp4, webm or gif, "
           "which need the ffmpeg program; webp is a film beside these or where --name has no "
           "{frame}, else pictures")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("NAME,...")
        ->check(one_of({"exr", "png", "jpg", "tif", "webp", "hdr", "mp4", "webm", "gif"}))
        ->default_str("png");
    add_views_option(app, c.views)->default_str("one, by --camera, else fit");
    app.add_flag("--use-file-cameras", c.use_file_cameras,
                 "Use the first camera of each file that has one; by default all assets are framed "
                 "alike");
    app.add_flag("--all-cameras", c.all_cameras, "Add a view for each camera of the file");
    add_turntable_option(app, c.turntable);
    add_frames_options(app, c.frames);
}

void add_run_options(CLI::App& app, BatchCli& c) {
    begin_group(app, "Batch");
    app.add_flag("--resume", c.resume, "Continue an earlier run of this batch");
    app.add_flag("--overwrite", c.overwrite,
                 "Replace files in --out that no batch made; by default they end the batch before "
                 "it starts");
    add_number(app, "--jobs", c.jobs, "N", "Worker processes", 1u, 4096u)
        ->default_str("the number of threads");
    add_number(app, "--timeout", c.timeout, "SECONDS", "Time limit per picture; 0: none", 0.0);
    add_number(app, "--memory", c.memory_mib, "MIB", "Memory limit per worker; 0: none",
               uint64_t{0});
    add_number(app, "--grace", c.grace, "SECONDS",
               "Time to finish pictures in progress after SIGTERM or Ctrl-C", 0.0);
    app.add_option("--log", c.log, "Append a JSON line per event to a file")->type_name("FILE");
    app.add_option("--compare-to", c.compare_to,
                   "Folder of an earlier batch; pictures that differ are marked")
        ->type_name("DIR")
        ->check(CLI::Validator(existing_folder_problem, {}));
    app.add_flag("--fail-on-change", c.fail_on_change,
                 "Exit with 3 if a picture differs from --compare-to");
    add_progress_option(app);
    app.add_flag("--quiet", c.quiet, "Print no progress and no summary");
}

void add_farm_options(CLI::App& app, BatchCli& c) {
    begin_group(app, "Farm");
    FarmOptions& f = c.farm_options;
    CLI::Option* farm = app.add_option("--farm", c.farm, "Render on a cluster (docs/farm.md)")
                            ->type_name("NAME")
                            ->check(one_of({"slurm"}));
    app.add_flag("--dry-run", c.dry_run, "Print the jobs instead of submitting them")->needs(farm);
    app.add_flag("--wait", c.wait, "Wait for the farm and exit with its status")->needs(farm);
    app.add_option("--farm-option", f.sbatch_options,
                   "Option passed to sbatch, such as --partition=short; may be repeated")
        ->type_name("OPTION")
        ->needs(farm)
        ->allow_extra_args(false);
    app.add_option("--farm-task-seconds", f.group_seconds,
                   "Intended duration of one element of the job array, in seconds")
        ->type_name("SECONDS")
        ->needs(farm)
        ->capture_default_str()
        ->check(positive_number());
    add_number(app, "--farm-elements", f.max_groups, "N",
               "Maximum number of elements of the job array", size_t{1}, size_t{1'000'000})
        ->needs(farm);
    add_number(app, "--farm-at-once", f.max_running, "N",
               "Maximum number of elements that run at the same time", size_t{0})
        ->needs(farm)
        ->default_str("no limit");
    add_number(app, "--farm-attempts", f.max_attempts, "N",
               "How often missing pictures are submitted", 1, 100)
        ->needs(farm);
}

}  // namespace

void add_batch_command(CLI::App& app) {
    const auto cli = std::make_shared<BatchCli>();
    CLI::App* sub =
        app.add_subcommand("batch", "Render many assets unattended, each in a process of its own");
    add_input_options(*sub, *cli);
    add_plan_options(*sub, *cli);
    add_picture_options(*sub, cli->render);
    cli->options = setting_options(*sub);
    add_run_options(*sub, *cli);
    add_farm_options(*sub, *cli);
    begin_group(*sub, "Other");
    sub->footer("Try `sightline batch assets/ --out pictures --views front,left`.");
    sub->callback([cli] { run_command(*cli); });
}

void add_worker_command(CLI::App& app) {
    const auto memory_mib = std::make_shared<uint64_t>(0);
    const auto parent = std::make_shared<int>(0);
    CLI::App* sub = app.add_subcommand("worker", "Started by `batch`");
    sub->group("");  // hidden
    sub->add_option("--memory", *memory_mib, "Memory limit; 0: none")->type_name("MIB");
    sub->add_option("--parent", *parent, "Id of the batch's process")->required()->type_name("ID");
    sub->callback([memory_mib, parent] {
        if (const int status = run_worker(parse_settings, *parent, *memory_mib))
            throw CLI::RuntimeError(status);
    });
}

}  // namespace sightline
