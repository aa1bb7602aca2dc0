#pragma once
// Runs a list of tasks in worker processes and keeps the journal.
#include "batch/journal.h"
#include "batch/pool.h"
#include "batch/task.h"

#include <atomic>

namespace sightline {

/// A task and how much there is to do for it (pixels times samples), to share the cores by.
struct PlannedTask {
    Task task;
    double work = 1;
    double pixels = 1;
};

/// How to run a batch.
struct BatchRun {
    std::string folder;  ///< absolute; must exist
    WorkerCommand worker;
    unsigned threads = 1;    ///< cores to keep busy
    unsigned jobs = 1;       ///< workers side by side
    double timeout = 0;      ///< seconds a task may take; 0: any
    double grace = 20;       ///< seconds that running tasks are given when the batch is to end
    std::string log;         ///< file for a JSON line per event; empty: none
    std::string compare_to;  ///< folder of an earlier batch; empty: none
    bool show_progress = true;
    /// How often the batch was asked to end: by the first it ends after the tasks in flight or
    /// the grace time, by the second at once.
    const std::atomic<int>* interrupts = nullptr;
};

/// What became of a batch: the outcome of each task in their order, as far as it came.
struct BatchResult {
    std::vector<Outcome> outcomes;
    bool interrupted = false;
    double seconds = 0;
};

/// Runs what `journal` does not show as done and unchanged. Throws Error where the machine, not a
/// task, is at fault: the folder is gone, the disk is full.
BatchResult run_batch(const std::vector<PlannedTask>& tasks, const BatchRun& run, Journal& journal);

/// Asks workers how many cameras each asset has; 0 for those that cannot be read.
std::vector<size_t> count_cameras(const std::vector<Task>& assets, const BatchRun& run);

/// Seconds that each task would take one core, by those of a few that are tried at a small size.
std::vector<double> estimate_seconds(const std::vector<PlannedTask>& tasks, const BatchRun& run);

/// Removes what writers that were killed left in the folders of the tasks' outputs.
void remove_leftovers(const std::vector<PlannedTask>& tasks, const std::string& folder);

}  // namespace sightline
