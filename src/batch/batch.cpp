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
#include <filesystem>
#include <set>
#include <utility>

namespace sightline {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Seconds that a unit of work takes, by asset where one of its pictures is done already.
class Costs {
  public:
    void learn(const PlannedTask& task, double seconds, unsigned threads) {
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

class Batch {
  public:
    Batch(const std::vector<PlannedTask>& tasks, const BatchRun& run, Journal& journal)
        : tasks_(tasks),
          run_(run),
          journal_(journal),
          pool_(run.worker),
          report_(tasks.size(), run.log, run.show_progress),
          threads_(tasks.size()),
          outcomes_(tasks.size()) {
        for (const PlannedTask& task : tasks) work_left_ += task.work;
    }

    BatchResult run() {
        const auto begin = Clock::now();
        BatchResult result;
        while (next_ < tasks_.size() || is_busy()) {
            if (interrupts() > 0) {
                result.interrupted = true;
                wind_up();
                break;
            }
            while (next_ < tasks_.size() && rendering() < run_.jobs) start(next_++);
            sync_staged();
            finish(pool_.wait(0.2));
            report_.tick();
        }
        check_folder();
        journal_.sync();
        for (auto& outcome : outcomes_)
            if (outcome) result.outcomes.push_back(std::move(*outcome));
        result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
        return result;
    }

  private:
    // A finished picture that is not on the disk yet.
    struct Staged {
        size_t task;
        Outcome outcome;
    };

    int interrupts() const { return run_.interrupts ? run_.interrupts->load() : 0; }

    size_t rendering() const { return pool_.running() - (syncing_.empty() ? 0 : 1); }
    bool is_busy() const { return pool_.running() > 0 || !staged_.empty(); }

    // As many threads as the task's share of all that is left: one while there are many tasks, all
    // for the last one or for one that would take as long as the rest together.
    unsigned share(const PlannedTask& task) const {
        const double left = std::max(work_left_ * costs_.mean(), costs_.estimate(task));
        const double cores = std::round(run_.threads * costs_.estimate(task) / left);
        return static_cast<unsigned>(std::clamp(cores, 1.0, static_cast<double>(run_.threads)));
    }

    void start(size_t i) {
        const PlannedTask& task = tasks_[i];
        threads_[i] = share(task);
        work_left_ -= task.work;
        const Outcome* earlier = journal_.find(task.task.key());
        report_.begin(task.task, threads_[i]);
        constexpr double large = 1 << 26;  // pixels times samples: a quarter of a minute
        WorkerRequest request;
        request.task = task.task;
        request.folder = run_.folder;
        request.compare_to = run_.compare_to;
        request.threads = threads_[i];
        request.keep_tiles = task.work >= large;
        if (earlier) request.earlier = to_json(*earlier).dump();
        pool_.submit(i, to_line(request), run_.timeout);
    }

    Outcome outcome_from(const WorkerResponse& answer) {
        const Task& task = tasks_[answer.id].task;
        if (answer.verdict == TaskVerdict::ok) {
            Outcome outcome = outcome_from_json(nlohmann::json::parse(answer.text));
            if (outcome.verdict == TaskVerdict::ok && !outcome.skipped)
                costs_.learn(tasks_[answer.id], answer.seconds, threads_[answer.id]);
            if (outcome.verdict != TaskVerdict::ok) outcome.log = answer.log;
            return outcome;
        }
        Outcome outcome = make_outcome(task);
        outcome.verdict = answer.verdict;
        outcome.message = answer.text;
        outcome.log = answer.log;
        outcome.seconds = answer.seconds;
        return outcome;
    }

    void finish(const std::vector<WorkerResponse>& answers) {
        std::vector<Staged> settled;
        for (const WorkerResponse& answer : answers) {
            if (answer.id == tasks_.size()) {
                std::ranges::move(synced(answer), std::back_inserter(settled));
                continue;
            }
            Outcome outcome = outcome_from(answer);
            auto& list = outcome.staged.empty() ? settled : staged_;
            list.push_back({answer.id, std::move(outcome)});
        }
        settle(std::move(settled));
    }

    // Waiting for the disk takes as long as rendering a small picture. So a worker does it, for all
    // pictures that were finished while it did so for those before; the journal's lines of those go
    // along.
    void sync_staged() {
        if (staged_.empty() || !syncing_.empty()) return;
        syncing_ = std::move(staged_);
        staged_.clear();
        WorkerRequest request;
        request.kind = WorkerRequest::Kind::sync;
        request.files.push_back(journal_.path());
        for (const Staged& staged : syncing_)
            for (const std::string& file : staged.outcome.staged)
                request.files.push_back((fs::path(run_.folder) / file).string());
        pool_.submit(tasks_.size(), to_line(request), 0);
    }

    // What the answer to a sync makes final.
    std::vector<Staged> synced(const WorkerResponse& answer) {
        std::vector<Staged> done = std::exchange(syncing_, {});
        if (answer.verdict != TaskVerdict::ok) {  // somebody killed the worker: once more
            std::ranges::move(done, std::back_inserter(staged_));
            return {};
        }
        if (!answer.text.empty()) {
            check_folder();
            throw Error(answer.text);
        }
        for (Staged& staged : done) put_in_place(staged.outcome);
        return done;
    }

    void put_in_place(Outcome& outcome) const {
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

    void settle(std::vector<Staged> finished) {
        std::vector<Outcome> news;
        bool failed = false;
        for (Staged& one : finished) {
            failed = failed || one.outcome.verdict != TaskVerdict::ok;
            if (!one.outcome.skipped) news.push_back(one.outcome);
            report_.end(one.outcome);
            outcomes_[one.task] = std::move(one.outcome);
        }
        if (!news.empty()) journal_.append(news);
        if (failed) check_folder();
    }

    // A folder that is gone or full fails every task: better to stop than to render for nothing.
    void check_folder() const {
        struct statvfs disk;
        if (statvfs(run_.folder.c_str(), &disk) != 0 || access(run_.folder.c_str(), W_OK) != 0)
            throw Error(run_.folder +
                        ": the output folder is gone or cannot be "
                        "written any more");
        if (static_cast<uint64_t>(disk.f_bavail) * disk.f_frsize < 1 << 18)
            throw Error(run_.folder + ": the disk is full; make room and continue with --resume");
    }

    void wind_up() {
        const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                            std::chrono::duration<double>(run_.grace));
        while (is_busy() && interrupts() < 2 && Clock::now() < end) {
            sync_staged();
            finish(pool_.wait(0.1));
        }
    }

    const std::vector<PlannedTask>& tasks_;
    const BatchRun& run_;
    Journal& journal_;
    WorkerPool pool_;
    BatchReport report_;
    Costs costs_;
    double work_left_ = 0;
    std::vector<unsigned> threads_;
    std::vector<std::optional<Outcome>> outcomes_;
    std::vector<Staged> staged_, syncing_;
    size_t next_ = 0;
};

// Answers to requests that make nothing; null where a worker came to harm.
std::vector<nlohmann::json> ask_workers(const std::vector<WorkerRequest>& requests,
                                        const BatchRun& run) {
    WorkerPool pool(run.worker);
    std::vector<nlohmann::json> answers(requests.size());
    for (size_t next = 0; next < requests.size() || pool.running() > 0;) {
        if (run.interrupts && *run.interrupts > 0) throw Error("interrupted");
        for (; next < requests.size() && pool.running() < run.jobs; ++next)
            pool.submit(next, to_line(requests[next]), run.timeout);
        for (const WorkerResponse& answer : pool.wait(0.2))
            if (answer.verdict == TaskVerdict::ok)
                answers[answer.id] = nlohmann::json::parse(answer.text);
    }
    return answers;
}

}  // namespace

BatchResult run_batch(const std::vector<PlannedTask>& tasks, const BatchRun& run,
                      Journal& journal) {
    return Batch(tasks, run, journal).run();
}

std::vector<size_t> count_cameras(const std::vector<Task>& assets, const BatchRun& run) {
    std::vector<WorkerRequest> requests(assets.size());
    for (size_t i = 0; i < assets.size(); ++i) {
        requests[i].kind = WorkerRequest::Kind::cameras;
        requests[i].task = assets[i];
    }
    std::vector<size_t> counts;
    for (const nlohmann::json& answer : ask_workers(requests, run))
        counts.push_back(answer.is_null() ? 0 : answer.at("cameras").get<size_t>());
    return counts;
}

std::vector<double> estimate_seconds(const std::vector<PlannedTask>& tasks, const BatchRun& run) {
    constexpr size_t most = 16;
    std::vector<WorkerRequest> requests;
    std::vector<size_t> tried;
    for (size_t k = 0; k < std::min(most, tasks.size()); ++k) {
        tried.push_back(k * tasks.size() / std::min(most, tasks.size()));
        requests.emplace_back();
        requests.back().kind = WorkerRequest::Kind::measure;
        requests.back().task = tasks[tried.back()].task;
    }
    double fixed = 0, rate = 0, measured = 0;
    const std::vector<nlohmann::json> answers = ask_workers(requests, run);
    for (size_t k = 0; k < answers.size(); ++k) {
        if (answers[k].is_null() || answers[k].at("per_pixel") == 0) continue;
        const PlannedTask& task = tasks[tried[k]];
        fixed += answers[k].at("fixed").get<double>();
        rate += answers[k].at("per_pixel").get<double>() * task.pixels / task.work;
        ++measured;
    }
    std::vector<double> seconds;
    for (const PlannedTask& task : tasks)
        // Nothing could be measured: a million samples a second.
        seconds.push_back(measured > 0 ? (fixed + rate * task.work) / measured
                                       : 0.1 + task.work * 1e-6);
    return seconds;
}

void remove_leftovers(const std::vector<PlannedTask>& tasks, const std::string& folder) {
    std::set<fs::path> folders{fs::path(folder), fs::path(folder) / private_folder / "thumbnails"};
    for (const PlannedTask& task : tasks)
        for (const std::string& output : task.task.outputs)
            folders.insert((fs::path(folder) / output).parent_path());
    std::error_code ignored;
    for (const fs::path& place : folders)
        for (const auto& entry : fs::directory_iterator(place, ignored))
            if (entry.path().filename().native().starts_with(temporary_prefix))
                fs::remove(entry.path(), ignored);
}

}  // namespace sightline
