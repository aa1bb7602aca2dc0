#include "batch/batch.h"

#include "batch/report.h"
#include "batch/thumbnail.h"
#include "batch/worker.h"
#include "core/error.h"
#include "core/files.h"

#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace sightline {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Seconds per unit of work: those measured for the same asset, otherwise the mean of all.
class CostModel {
  public:
    void add(const PlannedTask& task, double seconds, unsigned threads) {
        const double rate = seconds * threads / task.work;
        rates_[task.task.asset] = rate;
        sum_ += rate;
        ++count_;
    }

    double estimate(const PlannedTask& task) const {
        const auto known = rates_.find(task.task.asset);
        return task.work * (known != rates_.end() ? known->second : mean());
    }

    double mean() const { return count_ ? sum_ / static_cast<double>(count_) : 1; }

  private:
    std::map<std::string, double> rates_;
    double sum_ = 0;
    size_t count_ = 0;
};

/// The stages of a task in flight. A picture is committed in two phases: a worker renders it to
/// temporary files; then one sync covers the files of all rendered pictures and the journal,
/// after which they are renamed and their outcomes recorded.
enum class Stage { rendering, rendered, syncing };

struct TaskInFlight {
    Stage stage = Stage::rendering;
    unsigned threads = 1;
    Outcome outcome;  ///< once rendered
};

class Batch {
  public:
    Batch(const std::vector<PlannedTask>& tasks, const BatchRun& run, Journal& journal)
        : tasks_(tasks),
          run_(run),
          journal_(journal),
          pool_(run.worker),
          report_(tasks.size(), run.log, run.show_progress),
          outcomes_(tasks.size()) {
        for (const PlannedTask& task : tasks) work_left_ += task.work;
        for (size_t i = 0; i < tasks.size(); ++i) pending_.push_back(i);
    }

    BatchResult run() {
        const auto begin = Clock::now();
        BatchResult result;
        while (!pending_.empty() || !in_flight_.empty()) {
            if (interrupts() > 0) {
                result.interrupted = true;
                drain();
                break;
            }
            while (!pending_.empty() && count(Stage::rendering) < run_.jobs) start(take_next());
            advance(0.2);
            report_.update_bar();
        }
        check_folder();
        journal_.sync();
        for (auto& outcome : outcomes_)
            if (outcome) result.outcomes.push_back(std::move(*outcome));
        result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
        return result;
    }

  private:
    int interrupts() const { return run_.interrupts ? run_.interrupts->load() : 0; }

    size_t count(Stage stage) const {
        return static_cast<size_t>(std::ranges::count_if(
            in_flight_, [&](const auto& entry) { return entry.second.stage == stage; }));
    }

    // In proportion to the task's share of the remaining work: one thread while many tasks are
    // left, all for the last task or for one that would take as long as the rest together.
    unsigned threads_for(const PlannedTask& task) const {
        const double left = std::max(work_left_ * costs_.mean(), costs_.estimate(task));
        const double cores = std::round(run_.threads * costs_.estimate(task) / left);
        return static_cast<unsigned>(std::clamp(cores, 1.0, static_cast<double>(run_.threads)));
    }

    // The next task: of an asset that an idle worker has in memory, else of one that no worker has,
    // else the first. Looks at the first few alone, so that the order stays close to the plan's.
    size_t take_next() {
        constexpr size_t window = 256;
        auto chosen = pending_.begin();
        bool is_free = false;
        for (size_t k = 0; k < std::min(window, pending_.size()); ++k) {
            const auto at = pending_.begin() + static_cast<std::ptrdiff_t>(k);
            const auto holder = pool_.holder_of(tasks_[*at].task.asset);
            if (holder == WorkerPool::Holder::busy) continue;
            const bool is_held = holder == WorkerPool::Holder::idle;
            if (is_held || !is_free) chosen = at;
            is_free = true;
            if (is_held) break;
        }
        const size_t task = *chosen;
        pending_.erase(chosen);
        return task;
    }

    void start(size_t i) {
        constexpr double large = 1 << 26;  // pixels times samples: a quarter of a minute
        const PlannedTask& task = tasks_[i];
        const unsigned threads = threads_for(task);
        in_flight_[i].threads = threads;
        work_left_ -= task.work;
        report_.task_started(task.task, threads);
        WorkerRequest request;
        request.task = task.task;
        request.folder = run_.folder;
        request.compare_to = run_.compare_to;
        request.threads = threads;
        request.keep_tiles = task.work >= large;
        if (const Outcome* earlier = journal_.find(task.task.key()))
            request.earlier = to_json(*earlier).dump();
        pool_.submit(i, to_line(request), run_.timeout * task.pictures, task.task.asset);
    }

    // Waits up to `seconds` for workers and moves the tasks in flight to their next stages.
    void advance(double seconds) {
        start_sync();
        std::vector<size_t> finished;
        for (const WorkerResponse& response : pool_.wait(seconds))
            if (response.id == sync_id())
                finish_sync(response, finished);
            else
                finish_rendering(response, finished);
        record(finished);
    }

    void finish_rendering(const WorkerResponse& response, std::vector<size_t>& finished) {
        TaskInFlight& task = in_flight_.at(response.id);
        task.outcome = read_outcome(response, task.threads);
        task.stage = Stage::rendered;
        if (task.outcome.staged.empty()) finished.push_back(response.id);  // nothing to commit
    }

    Outcome read_outcome(const WorkerResponse& response, unsigned threads) {
        const PlannedTask& planned = tasks_[response.id];
        if (response.verdict == TaskVerdict::ok) {
            Outcome outcome = outcome_from_json(nlohmann::json::parse(response.text));
            if (has_picture(outcome.verdict) && !outcome.skipped)
                costs_.add(planned, response.seconds, threads);
            if (has_picture(outcome.verdict)) return outcome;
            outcome.log = response.log;
            outcome.seconds = response.seconds;
            return outcome;
        }
        Outcome outcome = make_outcome(planned.task);
        outcome.verdict = response.verdict;
        outcome.message = response.text;
        outcome.log = response.log;
        outcome.seconds = response.seconds;
        outcome.memory = response.memory;
        return outcome;
    }

    // A sync takes as long as rendering a small picture. Therefore a worker does it, for all
    // pictures that were rendered during the sync before; it includes the journal's last lines.
    void start_sync() {
        if (count(Stage::rendered) == 0 || count(Stage::syncing) > 0) return;
        WorkerRequest request;
        request.kind = WorkerRequest::Kind::sync;
        request.files.push_back(journal_.path());
        for (auto& [id, task] : in_flight_) {
            if (task.stage != Stage::rendered) continue;
            task.stage = Stage::syncing;
            for (const std::string& file : task.outcome.staged)
                request.files.push_back((fs::path(run_.folder) / file).string());
        }
        pool_.submit(sync_id(), to_line(request), 0);
    }

    void finish_sync(const WorkerResponse& response, std::vector<size_t>& finished) {
        const bool synced = response.verdict == TaskVerdict::ok;
        if (synced && !response.text.empty()) {
            check_folder();
            throw Error(response.text);
        }
        for (auto& [id, task] : in_flight_) {
            if (task.stage != Stage::syncing) continue;
            task.stage = Stage::rendered;  // to be synced again if the worker was killed
            if (!synced) continue;
            rename_outputs(task.outcome);
            finished.push_back(id);
        }
    }

    void rename_outputs(Outcome& outcome) const {
        const fs::path folder(run_.folder);
        std::error_code error;
        for (size_t i = 0; i < outcome.staged.size() && !error; ++i)
            fs::rename(folder / outcome.staged[i], folder / outcome.outputs[i].path, error);
        outcome.staged.clear();
        if (!error) return;
        outcome.verdict = TaskVerdict::failed;
        outcome.message =
            fmt::format("{}: cannot write: {}", outcome.outputs[0].path, error.message());
    }

    void record(const std::vector<size_t>& finished) {
        std::vector<Outcome> lines;
        bool failed = false;
        for (const size_t id : finished) {
            const Outcome& outcome = outcomes_[id].emplace(std::move(in_flight_[id].outcome));
            in_flight_.erase(id);
            failed = failed || !has_picture(outcome.verdict);
            if (!outcome.skipped) lines.push_back(outcome);
            report_.task_finished(outcome);
        }
        if (!lines.empty()) journal_.append(lines);
        if (failed) check_folder();
    }

    // A missing folder or a full disk would fail every further task.
    void check_folder() const {
        struct statvfs disk;
        if (statvfs(run_.folder.c_str(), &disk) != 0 || access(run_.folder.c_str(), W_OK) != 0)
            throw Error(run_.folder + ": the output folder is gone or cannot be written any more");
        if (static_cast<uint64_t>(disk.f_bavail) * disk.f_frsize < 1 << 18)
            throw Error(run_.folder + ": the disk is full; free space and continue with --resume");
    }

    // After an interrupt: commits what is in flight while the grace time lasts.
    void drain() {
        const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                            std::chrono::duration<double>(run_.grace));
        while (!in_flight_.empty() && interrupts() < 2 && Clock::now() < end) advance(0.1);
    }

    size_t sync_id() const { return tasks_.size(); }

    const std::vector<PlannedTask>& tasks_;
    const BatchRun& run_;
    Journal& journal_;
    WorkerPool pool_;
    BatchReport report_;
    CostModel costs_;
    double work_left_ = 0;
    std::map<size_t, TaskInFlight> in_flight_;      // by index
    std::vector<std::optional<Outcome>> outcomes_;  // of the finished tasks
    std::deque<size_t> pending_;                    // tasks that have not started
};

// The JSON responses to requests that write nothing; null where the worker failed or crashed.
std::vector<nlohmann::json> run_requests(const std::vector<WorkerRequest>& requests,
                                         const BatchRun& run) {
    WorkerPool pool(run.worker);
    std::vector<nlohmann::json> responses(requests.size());
    for (size_t next = 0; next < requests.size() || pool.running() > 0;) {
        if (run.interrupts && *run.interrupts > 0) throw Error("interrupted");
        for (; next < requests.size() && pool.running() < run.jobs; ++next)
            pool.submit(next, to_line(requests[next]), run.timeout);
        for (const WorkerResponse& response : pool.wait(0.2))
            if (response.verdict == TaskVerdict::ok)
                responses[response.id] = nlohmann::json::parse(response.text);
    }
    return responses;
}

}  // namespace

BatchResult run_batch(const std::vector<PlannedTask>& tasks, const BatchRun& run,
                      Journal& journal) {
    return Batch(tasks, run, journal).run();
}

std::vector<std::optional<std::vector<std::string>>> list_cameras(const std::vector<Task>& assets,
                                                                  const BatchRun& run) {
    std::vector<WorkerRequest> requests(assets.size());
    for (size_t i = 0; i < assets.size(); ++i) {
        requests[i].kind = WorkerRequest::Kind::cameras;
        requests[i].task = assets[i];
    }
    std::vector<std::optional<std::vector<std::string>>> lists;
    for (const nlohmann::json& response : run_requests(requests, run)) {
        auto& list = lists.emplace_back();
        if (response.is_null()) continue;
        list.emplace();
        for (const nlohmann::json& name : response.at("cameras"))
            list->push_back(bytes_from_json(name));
    }
    return lists;
}

std::vector<double> estimate_seconds(const std::vector<PlannedTask>& tasks, const BatchRun& run) {
    const size_t count = std::min<size_t>(16, tasks.size());
    std::vector<WorkerRequest> requests(count);
    std::vector<size_t> sample(count);
    for (size_t k = 0; k < count; ++k) {
        sample[k] = k * tasks.size() / count;
        requests[k].kind = WorkerRequest::Kind::measure;
        requests[k].task = tasks[sample[k]].task;
    }
    double fixed = 0, rate = 0, measured = 0;
    const std::vector<nlohmann::json> responses = run_requests(requests, run);
    for (size_t k = 0; k < count; ++k) {
        if (responses[k].is_null() || responses[k].at("per_pixel") == 0) continue;
        const PlannedTask& task = tasks[sample[k]];
        fixed += responses[k].at("fixed").get<double>();
        rate += responses[k].at("per_pixel").get<double>() * task.pixels / task.work;
        ++measured;
    }
    std::vector<double> seconds;
    for (const PlannedTask& task : tasks)
        seconds.push_back(measured > 0
                              ? (fixed + rate * task.work) / measured
                              : 0.1 + task.work * 1e-6);  // assume a million samples a second
    return seconds;
}

void remove_leftovers(const std::vector<PlannedTask>& tasks, const std::string& folder) {
    std::set<fs::path> folders{fs::path(folder), fs::path(folder) / private_folder / "thumbnails"};
    for (const PlannedTask& task : tasks)
        for (const std::string& output : task.task.outputs)
            folders.insert((fs::path(folder) / output).parent_path());
    std::error_code ignored;
    for (const fs::path& subfolder : folders)
        for (const auto& entry : fs::directory_iterator(subfolder, ignored))
            if (entry.path().filename().native().starts_with(temporary_prefix))
                fs::remove(entry.path(), ignored);
}

}  // namespace sightline
