#include "batch/farm.h"

#include "batch/thumbnail.h"
#include "batch/worker.h"
#include "core/error.h"
#include "core/files.h"

#include <fmt/format.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <thread>

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int try_again = 75;  // EX_TEMPFAIL, the usual value of Slurm's RequeueExit

// Paths below the batch's folder.
fs::path farm_folder(const std::string& folder) {
    return fs::path(folder) / private_folder / "farm";
}

fs::path group_file(const std::string& folder, size_t group) {
    return farm_folder(folder) / "groups" / fmt::format("{}.json", group);
}

json read_json(const fs::path& path) {
    const auto bytes = read_file(path.string(), uint64_t{1} << 32);
    const auto* text = reinterpret_cast<const char*>(bytes.data());
    json parsed = json::parse(text, text + bytes.size(), nullptr, false);
    if (parsed.is_discarded())
        throw Error(path.string() + ": is damaged; submit the batch again with --resume");
    return parsed;
}

json to_json(const Farm& farm) {
    const BatchRun& r = farm.run;
    const FarmOptions& o = farm.options;
    return {{"threads", r.threads},
            {"jobs", r.jobs},
            {"timeout", r.timeout},
            {"grace", r.grace},
            {"compare_to", r.compare_to},
            {"program", o.program},
            {"options", o.sbatch_options},
            {"attempts", o.max_attempts},
            {"memory", o.memory_mib},
            {"at_once", o.max_running},
            {"fail_on_change", o.fail_on_change},
            {"groups", farm.groups},
            {"attempt", farm.attempt}};
}

Farm read_farm(const std::string& folder) {
    const json j = read_json(farm_folder(folder) / "farm.json");
    Farm farm;
    BatchRun& r = farm.run;
    FarmOptions& o = farm.options;
    r.folder = folder;
    r.threads = j.at("threads"), r.jobs = j.at("jobs");
    r.timeout = j.at("timeout"), r.grace = j.at("grace");
    r.compare_to = j.at("compare_to");
    r.show_progress = false;
    o.program = j.at("program"), o.sbatch_options = j.at("options").get<std::vector<std::string>>();
    o.max_attempts = j.at("attempts"), o.memory_mib = j.at("memory");
    o.max_running = j.at("at_once");
    o.fail_on_change = j.at("fail_on_change");
    r.worker = worker_command(o.program, o.memory_mib);
    farm.groups = j.at("groups"), farm.attempt = j.at("attempt");
    return farm;
}

std::vector<PlannedTask> read_group(const std::string& folder, size_t group) {
    std::vector<PlannedTask> tasks;
    for (const json& task : read_json(group_file(folder, group)))
        tasks.push_back({task_from_json(task), task.at("work"), 1, task.value("pictures", 1.0)});
    return tasks;
}

// The outcomes of all runs of a group so far. Each run has its own file, since an element may run
// twice at once and a node may die in the middle of a line.
std::vector<Outcome> read_group_outcomes(const std::string& folder, size_t group) {
    std::vector<std::string> files;
    const std::string prefix = fmt::format("{}.", group);
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(farm_folder(folder) / "parts", ignored))
        if (entry.path().filename().native().starts_with(prefix)) files.push_back(entry.path());
    std::ranges::sort(files);
    std::vector<Outcome> outcomes;
    for (const std::string& file : files)
        std::ranges::move(read_outcomes(file), std::back_inserter(outcomes));
    // The last outcome of a task counts: put successes after failures.
    std::ranges::stable_sort(outcomes, std::less<>(),
                             [](const Outcome& o) { return has_picture(o.verdict); });
    return outcomes;
}

std::string make_script(const Farm& farm, const std::string& name, const std::string& command) {
    std::string text = "#!/bin/bash\n";
    std::vector<std::string> lines = {
        "--job-name=" + name, "--requeue", "--open-mode=append",
        fmt::format("--output=\"{}\"",
                    (farm_folder(farm.run.folder) / "log" / "%x-%A-%a.txt").string()),
        fmt::format("--cpus-per-task={}", farm.run.threads),
        // Sent to the batch before the time limit, so that it can finish.
        fmt::format("--signal=B:TERM@{:.0f}", farm.run.grace + 10)};
    if (farm.options.memory_mib)
        lines.push_back(fmt::format("--mem={}M", farm.options.memory_mib * farm.run.jobs + 256));
    lines.insert(lines.end(), farm.options.sbatch_options.begin(),
                 farm.options.sbatch_options.end());
    for (const std::string& line : lines) text += "#SBATCH " + line + "\n";
    return text + "exec " + shell_quoted(farm.options.program) + " " + command + " --out " +
           shell_quoted(farm.run.folder) + "\n";
}

// Runs sbatch; returns the number of the job.
std::string sbatch(const std::string& arguments) {
    const std::string command = "sbatch --parsable " + arguments;
    FILE* output = popen(command.c_str(), "r");
    if (!output) throw Error("cannot run sbatch; is Slurm installed on this machine?");
    std::array<char, 256> line{};
    const bool read = fgets(line.data(), line.size(), output) != nullptr;
    if (pclose(output) != 0 || !read) throw Error("sbatch failed: " + command);
    std::string job(line.data());
    return job.substr(0, job.find_first_of(";\n"));
}

PlannedTask whole_picture(PlannedTask part) {
    part.work *= part.task.parts;
    part.task.part = 0;
    part.task.parts = 1;
    return part;
}

void write_state(const Farm& farm) {
    write_text((farm_folder(farm.run.folder) / "farm.json").string(), to_json(farm).dump());
}

// The tasks of all groups and their outcomes.
struct Collected {
    std::vector<Task> tasks;  // except those in parts
    std::vector<Outcome> outcomes;
    std::vector<PlannedTask> in_parts;  // as whole pictures
    std::vector<size_t> incomplete;     // groups with a task or part that has no outcome
};

Collected collect(const Farm& farm) {
    Collected result;
    for (size_t group = 0; group < farm.groups; ++group) {
        std::map<std::string, Outcome> by_key;
        for (Outcome& outcome : read_group_outcomes(farm.run.folder, group))
            by_key.insert_or_assign(outcome.key, std::move(outcome));
        bool complete = true;
        for (PlannedTask& task : read_group(farm.run.folder, group)) {
            const auto outcome = by_key.find(task.task.key());
            complete = complete && outcome != by_key.end();
            if (task.task.parts > 1) {
                if (task.task.part == 0) result.in_parts.push_back(whole_picture(std::move(task)));
                continue;
            }
            if (outcome != by_key.end()) result.outcomes.push_back(std::move(outcome->second));
            result.tasks.push_back(std::move(task.task));
        }
        if (!complete) result.incomplete.push_back(group);
    }
    return result;
}

}  // namespace

std::vector<TaskRange> make_groups(const std::vector<double>& seconds, double group_seconds,
                                   size_t max_groups) {
    const double total = std::accumulate(seconds.begin(), seconds.end(), 0.0);
    const double count =
        std::clamp(std::ceil(total / group_seconds), 1.0, static_cast<double>(max_groups));
    // Cuts where the running sum passes multiples of a group's share, so that the deviations of the
    // groups do not add up in the last one.
    std::vector<TaskRange> groups;
    double before = 0, end = 0;
    for (size_t i = 0; i < seconds.size(); ++i) {
        if (groups.empty() || before >= end) {
            groups.push_back({i, 0});
            const double share = total / count;
            end = (std::floor(before / share) + 1) * share;
        }
        ++groups.back().count;
        before += seconds[i];
    }
    return groups;
}

std::vector<PlannedTask> split_large(const std::vector<PlannedTask>& tasks, double group_seconds,
                                     std::vector<double>& seconds) {
    constexpr double max_parts = 1000, min_work = 1 << 16;  // less is not worth a start
    std::vector<PlannedTask> result;
    std::vector<double> shares;
    for (size_t i = 0; i < tasks.size(); ++i) {
        const double wanted =
            std::min({std::ceil(seconds[i] / group_seconds), tasks[i].work / min_work, max_parts});
        const unsigned parts =
            wanted > 2 && tasks[i].task.film.empty() ? static_cast<unsigned>(wanted) : 1;
        for (unsigned part = 0; part < parts; ++part) {
            result.push_back(tasks[i]);
            result.back().task.part = part;
            result.back().task.parts = parts;
            result.back().work /= parts;
            shares.push_back(seconds[i] / parts);
        }
    }
    seconds = std::move(shares);
    return result;
}

FarmPlan plan_farm(const std::vector<PlannedTask>& tasks, const BatchRun& run,
                   const FarmOptions& options) {
    std::vector<double> seconds = estimate_seconds(tasks, run);
    const auto lanes = static_cast<double>(std::max(1u, std::min(run.threads, run.jobs)));
    for (double& s : seconds) s /= lanes;
    FarmPlan plan;
    plan.tasks = split_large(tasks, options.group_seconds, seconds);
    plan.groups = make_groups(seconds, options.group_seconds, options.max_groups);
    plan.farm = {run, options, plan.groups.size()};
    plan.array_script = make_script(plan.farm, "sightline", "farm-part");
    plan.merge_script = make_script(plan.farm, "sightline-merge", "farm-merge");
    return plan;
}

void write_farm(const FarmPlan& plan) {
    const std::string& folder = plan.farm.run.folder;
    for (const char* name : {"groups", "parts", "log"})
        fs::create_directories(farm_folder(folder) / name);
    for (size_t g = 0; g < plan.groups.size(); ++g) {
        json list = json::array();
        const TaskRange& group = plan.groups[g];
        for (size_t i = group.first; i < group.first + group.count; ++i) {
            list.push_back(to_json(plan.tasks[i].task));
            list.back()["work"] = plan.tasks[i].work;
            list.back()["pictures"] = plan.tasks[i].pictures;
        }
        write_text(group_file(folder, g).string(), list.dump());
    }
    fs::remove(farm_folder(folder) / "status.json");
    write_state(plan.farm);
    write_text((farm_folder(folder) / "array.sh").string(), plan.array_script);
    write_text((farm_folder(folder) / "merge.sh").string(), plan.merge_script);
}

std::string submit_farm(const Farm& farm, const std::vector<size_t>& groups) {
    std::string elements;
    for (size_t i = 0; i < groups.size();) {
        size_t end = i + 1;
        while (end < groups.size() && groups[end] == groups[end - 1] + 1) ++end;
        elements += elements.empty() ? "" : ",";
        elements += end - i > 1 ? fmt::format("{}-{}", groups[i], groups[end - 1])
                                : fmt::format("{}", groups[i]);
        i = end;
    }
    if (farm.options.max_running) elements += fmt::format("%{}", farm.options.max_running);
    const fs::path folder = farm_folder(farm.run.folder);
    const std::string array =
        sbatch("--array=" + elements + " " + shell_quoted((folder / "array.sh").string()));
    // Not afterok, which never starts after a requeue. The merge job finds missing outcomes itself.
    return sbatch("--dependency=afterany:" + array + " " +
                  shell_quoted((folder / "merge.sh").string()));
}

int run_farm_part(const std::string& folder, size_t group, const std::atomic<int>* interrupts) {
    Farm farm = read_farm(folder);
    farm.run.interrupts = interrupts;
    const std::vector<PlannedTask> tasks = read_group(folder, group);
    std::array<char, 256> host{};
    gethostname(host.data(), host.size() - 1);
    const auto ticks = std::chrono::steady_clock::now().time_since_epoch().count();
    Journal journal((farm_folder(folder) / "parts" /
                     fmt::format("{}.{}.{}.{:x}.jsonl", group, host.data(), getpid(), ticks))
                        .string(),
                    false);
    journal.add_earlier(read_group_outcomes(folder, group));
    const BatchResult result = run_batch(tasks, farm.run, journal);
    return result.outcomes.size() == tasks.size() ? 0 : try_again;
}

FarmResult merge_farm(const std::string& folder) {
    Farm farm = read_farm(folder);
    Journal journal((fs::path(folder) / journal_name).string(), true);
    Collected found = collect(farm);
    FarmResult result;
    result.passed_over = journal.passed_over();
    result.compare_to = farm.run.compare_to;
    result.fail_on_change = farm.options.fail_on_change;
    if (!found.incomplete.empty() && farm.attempt < farm.options.max_attempts) {
        ++farm.attempt;
        write_state(farm);
        submit_farm(farm, found.incomplete);
        result.resubmitted = true;
        return result;
    }
    journal.append(found.outcomes);
    // Reads the tiles that the parts left; traces only those still missing after the last attempt.
    const BatchResult joined = run_batch(found.in_parts, farm.run, journal);
    result.tasks = std::move(found.tasks);
    for (PlannedTask& task : found.in_parts) result.tasks.push_back(std::move(task.task));
    result.outcomes = std::move(found.outcomes);
    result.outcomes.insert(result.outcomes.end(), joined.outcomes.begin(), joined.outcomes.end());
    return result;
}

void finish_farm(const std::string& folder, int status) {
    write_text((farm_folder(folder) / "status.json").string(), json{{"status", status}}.dump());
}

int wait_for_farm(const std::string& folder, const std::atomic<int>& interrupts) {
    const fs::path status = farm_folder(folder) / "status.json";
    while (!fs::exists(status)) {
        if (interrupts > 0) throw Error("stopped waiting; the submitted jobs keep running");
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
    return read_json(status).at("status");
}

}  // namespace sightline
