#include "batch/worker.h"

#include "batch/film_task.h"
#include "batch/thumbnail.h"
#include "core/error.h"
#include "core/file_clash.h"
#include "core/files.h"
#include "core/hash.h"
#include "core/memory.h"
#include "core/plain_reason.h"
#include "output/formats.h"
#include "output/render_asset.h"
#include "output/statistics.h"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <new>

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::array<std::string_view, 4> kinds = {"render", "cameras", "measure", "sync"};

bool has_hash(const std::string& path, uint64_t hash, bool shared) {
    try {
        return (shared ? hash_shared_file(path) : hash_file(path)) == hash;
    } catch (const Error&) {
        return false;
    }
}

// True if an earlier run did this task with the same inputs, and its outputs are unchanged.
bool is_done(const WorkerRequest& request, const Outcome& earlier) {
    const auto input_unchanged = [](const FileHash& f) {
        return f.hash == SourceFile::missing ? !fs::exists(f.path) : has_hash(f.path, f.hash, true);
    };
    const auto output_unchanged = [&](const FileHash& f) {
        return has_hash((fs::path(request.folder) / f.path).string(), f.hash, false);
    };
    // A part has no outputs, only tiles, which are reused when it runs again.
    return request.task.parts == 1 && has_picture(earlier.verdict) &&
           earlier.key == request.task.key() &&
           std::ranges::all_of(earlier.inputs, input_unchanged) &&
           std::ranges::all_of(earlier.outputs, output_unchanged);
}

void describe(const AssetResult& result, Outcome& outcome) {
    for (const SourceFile& input : result.inputs)
        outcome.inputs.push_back({input.path, input.hash});
    outcome.warnings = result.warnings;
    outcome.faults = result.faults;
    outcome.fault_count = result.fault_count;
    for (const uint64_t rays : result.picture.counters.rays) outcome.rays += rays;
    outcome.seconds = result.seconds.total;
    for (const auto& [stage, seconds] : stages_of(result.seconds)) outcome.stages[stage] = seconds;
    if (outcome.fault_count > 0) {
        const FoundFault& first = outcome.faults[0];
        outcome.verdict = TaskVerdict::drawn_with_faults;
        outcome.message = fmt::format(
            "{}: {}{}", first.place, first.text,
            outcome.fault_count > 1 ? fmt::format(" (and {} more)", outcome.fault_count - 1) : "");
    }
    if (result.content == PictureContent::something) return;
    outcome.verdict =
        result.content == PictureContent::empty ? TaskVerdict::empty : TaskVerdict::black;
    outcome.message = result.warnings.back();
}

/// The asset of the last task, which often has more pictures.
std::unique_ptr<Asset> kept_asset;

/// The asset is let go before another is read, so that the limit and the peak of memory are those
/// of one.
RenderedPicture render_kept_asset(const RenderCommand& command) {
    if (!kept_asset || !kept_asset->serves(command)) {
        kept_asset.reset();
        reset_peak_memory();
        kept_asset = std::make_unique<Asset>(command);
    }
    return kept_asset->render_unwritten(command);
}

void render_part(const WorkerRequest& request, RenderCommand& command, Outcome& outcome) {
    // Nothing is written to them, but their extensions decide which layers the tiles have.
    for (const std::string& output : request.task.outputs)
        command.output.pictures.push_back(
            (fs::path(request.folder) / fs::path(output).filename()).string());
    command.run.part = {request.task.part, request.task.parts};
    command.run.resume = false;
    describe(render_kept_asset(command).write(), outcome);
}

// Renders to temporary files in the batch's folder and fills `outcome`.
void render_into(const WorkerRequest& request, const ParseSettings& parse, Outcome& outcome) {
    const fs::path folder(request.folder);
    // Creating the folder again would hide that the journal is gone, too.
    if (!fs::is_directory(folder)) throw Error(request.folder + ": the output folder is gone");
    RenderCommand command = parse(request.task.asset, request.task.settings);
    OutputOptions& output = command.output;
    RunOptions& run = command.run;
    run.threads = request.threads;
    output.preview = true;
    output.command = render_command(request.task);
    run.tiles = (folder / tiles_path(request.task.name)).string();
    // Also resumes from tiles that an earlier run left.
    run.resume = request.keep_tiles || fs::exists(run.tiles);
    fs::create_directories(fs::path(run.tiles).parent_path());
    if (request.task.parts > 1) return render_part(request, command, outcome);
    const std::vector<std::string>& outputs = request.task.outputs;
    const size_t pictures = outputs.size() - output.data.size();
    for (size_t i = 0; i < outputs.size(); ++i) {
        const fs::path path = folder / outputs[i];
        fs::create_directories(path.parent_path());
        if (i < pictures)
            output.pictures.push_back(temporary_for(path) + path.extension().string());
        output.destinations.push_back(path.string());
    }
    const std::vector<std::string> written = files_of(output);
    for (const std::string& file : written)
        outcome.staged.push_back(fs::path(file).lexically_relative(folder));
    const AssetResult result =
        request.task.film.empty()
            ? render_kept_asset(command).write()
            : make_film(request, parse, command, output.pictures, render_kept_asset);
    const std::string thumbnail = thumbnail_path(request.task.name);
    write_thumbnail((folder / thumbnail).string(), result.preview);
    for (size_t i = 0; i < written.size(); ++i)
        outcome.outputs.push_back({outputs[i], hash_file(written[i])});
    outcome.outputs.push_back({thumbnail, hash_file((folder / thumbnail).string())});
    describe(result, outcome);
}

void discard_staged(const fs::path& folder, Outcome& outcome) {
    std::error_code ignored;
    for (const std::string& file : outcome.staged) fs::remove(folder / file, ignored);
    outcome.staged.clear();
}

std::string list_cameras(const WorkerRequest& request, const ParseSettings& parse) {
    RenderCommand command = parse(request.task.asset, request.task.settings);
    command.load.decode_images = false;
    const Scene scene = load_gltf(command.asset, command.load);
    json names = json::array();
    for (const Camera& camera : scene.cameras) names.push_back(bytes_to_json(camera.name));
    return json{{"cameras", names}}.dump();
}

// Renders the picture at an eighth of its size; the path depth stays the same.
std::string measure(const WorkerRequest& request, const ParseSettings& parse) {
    RenderCommand command = parse(request.task.asset, request.task.settings);
    RenderSettings& settings = command.settings;
    settings.width = std::max(1, settings.width / 8);
    settings.height = std::max(1, settings.height / 8);
    settings.crop = {};
    command.run.threads = 1;
    const StageTimes seconds = render_asset(command).seconds;
    const double pixels = static_cast<double>(settings.width) * settings.height;
    return json{{"fixed", seconds.load() + seconds.build + seconds.prepare},
                {"per_pixel", seconds.render / pixels}}
        .dump();
}

std::string sync(const std::vector<std::string>& files) {
    try {
        sync_to_disk(files);
        return "";
    } catch (const Error& e) {
        return e.what();
    }
}

// In MiB; 0 if there is none.
uint64_t memory_limit() {
    rlimit limit{};
    getrlimit(RLIMIT_DATA, &limit);
    return limit.rlim_cur == RLIM_INFINITY ? 0 : limit.rlim_cur >> 20;
}

std::string respond(const WorkerRequest& request, const ParseSettings& parse) {
    if (request.kind == WorkerRequest::Kind::sync) return sync(request.files);
    if (request.kind == WorkerRequest::Kind::render)
        return to_json(run_task(request, parse))
            .dump(-1, ' ', false, json::error_handler_t::replace);
    const bool cameras = request.kind == WorkerRequest::Kind::cameras;
    try {
        return cameras ? list_cameras(request, parse) : measure(request, parse);
    } catch (const std::exception&) {
        // The error is reported when the asset is rendered.
        return "null";
    }
}

}  // namespace

std::string to_line(const WorkerRequest& r) {
    json files = json::array();
    for (const std::string& file : r.files) files.push_back(bytes_to_json(file));
    return json{{"kind", kinds[static_cast<size_t>(r.kind)]},
                {"task", to_json(r.task)},
                {"folder", bytes_to_json(r.folder)},
                {"compare_to", bytes_to_json(r.compare_to)},
                {"threads", r.threads},
                {"keep_tiles", r.keep_tiles},
                {"earlier", r.earlier},
                {"files", files}}
        .dump();
}

WorkerRequest request_from_line(const std::string& line) {
    const json j = json::parse(line);
    const auto kind = std::ranges::find(kinds, j.at("kind").get<std::string>()) - kinds.begin();
    WorkerRequest request{static_cast<WorkerRequest::Kind>(kind),
                          task_from_json(j.at("task")),
                          bytes_from_json(j.at("folder")),
                          bytes_from_json(j.at("compare_to")),
                          j.at("threads"),
                          j.at("keep_tiles"),
                          j.at("earlier"),
                          {}};
    for (const json& file : j.at("files")) request.files.push_back(bytes_from_json(file));
    return request;
}

Outcome run_task(const WorkerRequest& request, const ParseSettings& parse) {
    Outcome outcome = make_outcome(request.task);
    reset_peak_memory();
    try {
        if (!request.earlier.empty()) outcome = outcome_from_json(json::parse(request.earlier));
        if (!request.earlier.empty() && is_done(request, outcome)) {
            outcome.skipped = true;
        } else {
            outcome = make_outcome(request.task);
            render_into(request, parse, outcome);
        }
        const std::string& current =
            outcome.staged.empty() ? request.task.outputs[0] : outcome.staged[0];
        outcome.change =
            compare_with_earlier(request.task, request.folder, current, request.compare_to);
    } catch (const OutputIsInput& e) {
        outcome.verdict = TaskVerdict::output_is_input;
        outcome.message = e.what();
    } catch (const std::bad_alloc&) {
        kept_asset.reset();
        outcome.verdict = TaskVerdict::out_of_memory;
        outcome.message = out_of_memory_message(memory_limit());
    } catch (const std::exception& e) {
        outcome.verdict = TaskVerdict::failed;
        outcome.message = plain_reason(e);
    }
    if (!has_picture(outcome.verdict)) discard_staged(request.folder, outcome);
    outcome.memory = peak_memory();
    return outcome;
}

WorkerCommand worker_command(const std::string& program, uint64_t memory_mib) {
    return {
        program,
        {"worker", "--parent", std::to_string(getpid()), "--memory", std::to_string(memory_mib)},
        memory_mib};
}

int run_worker(const ParseSettings& parse, int parent, uint64_t memory_mib) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) return 1;  // the parent died before prctl
    std::signal(SIGINT, SIG_IGN);
    std::signal(SIGTERM, SIG_IGN);
    // If the machine runs out of memory, it kills workers before the batch.
    std::ofstream("/proc/self/oom_score_adj") << 1000;
    sync_files(false);  // the batch syncs many files at once
    if (memory_mib) {
        const rlimit limit{memory_mib << 20, memory_mib << 20};
        setrlimit(RLIMIT_DATA, &limit);
    }
    // Responses alone use the pipe; anything a library prints goes to stderr.
    const int responses = dup(STDOUT_FILENO);
    dup2(STDERR_FILENO, STDOUT_FILENO);
    for (std::string line; std::getline(std::cin, line);) {
        const std::string response = respond(request_from_line(line), parse) + "\n";
        if (!write_all(responses, std::as_bytes(std::span(response)))) return 1;
    }
    return 0;
}

}  // namespace sightline
