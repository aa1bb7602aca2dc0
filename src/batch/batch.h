#pragma once
// Runs a list of tasks in worker processes and records their outcomes in the journal.
#include "batch/journal.h"
#include "batch/pool.h"
#include "batch/task.h"

#include <atomic>
#include <optional>
#include <string>
#include <vector>

namespace sightline {

/// A task with an estimate of its work, by which the cores are shared.
struct PlannedTask {
    Task task;
    double work = 1;  ///< pixels times samples
    double pixels = 1;
    double pictures = 1;  ///< frames of a film
};

/// How to run a batch.
struct BatchRun {
    std::string folder;  ///< absolute; must exist
    WorkerCommand worker;
    unsigned threads = 1;    ///< cores to keep busy
    unsigned jobs = 1;       ///< maximum number of workers that render at once
    double timeout = 0;      ///< time limit per picture, seconds; 0: none
    double grace = 20;       ///< time for running tasks to finish after an interrupt, seconds
    std::string log;         ///< file that gets a JSON line per event; empty: none
    std::string compare_to;  ///< folder of an earlier batch; empty: none
    bool show_progress = true;
    /// Number of interrupts so far. After the first, the batch ends when the tasks in flight are
    /// done or the grace time is over; after the second, at once.
    const std::atomic<int>* interrupts = nullptr;
};

/// The outcomes of the tasks that ended, in the order of the tasks.
struct BatchResult {
    std::vector<Outcome> outcomes;
    bool interrupted = false;
    double seconds = 0;
};

/// Runs the tasks that are not done and unchanged according to `journal`. Throws Error if the
/// machine, not a task, is at fault: the folder is gone, the disk is full.
BatchResult run_batch(const std::vector<PlannedTask>& tasks, const BatchRun& run, Journal& journal);

/// The names of the cameras in each asset, as workers read them; none for unreadable assets.
std::vector<std::optional<std::vector<std::string>>> list_cameras(const std::vector<Task>& assets,
                                                                  const BatchRun& run);

/// Estimated seconds of each task on one core, from a sample of tasks rendered at a small size.
std::vector<double> estimate_seconds(const std::vector<PlannedTask>& tasks, const BatchRun& run);

/// Removes temporary files that killed writers left in the folders of the tasks' outputs.
void remove_leftovers(const std::vector<PlannedTask>& tasks, const std::string& folder);

}  // namespace sightline
