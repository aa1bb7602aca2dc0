#pragma once
// A batch spread over the nodes of a Slurm cluster: a job array, and a job that merges its results.
#include "batch/batch.h"

namespace sightline {

/// How to run a batch on a farm.
struct FarmOptions {
    std::string program;                      ///< path of sightline on every node
    std::vector<std::string> sbatch_options;  ///< additional ones, such as --partition=short
    double group_seconds = 120;               ///< target time of one element of the array
    size_t max_groups = 1000;     ///< maximum number of elements (Slurm's MaxArraySize is 1001)
    size_t max_running = 0;       ///< maximum number of elements that run at once; 0: unlimited
    int max_attempts = 3;         ///< how many times incomplete groups are submitted
    uint64_t memory_mib = 0;      ///< memory of a worker; 0: unlimited
    bool fail_on_change = false;  ///< see FarmResult
};

/// Consecutive tasks for one element of the array.
struct TaskRange {
    size_t first = 0, count = 0;
};

/// Splits tasks into at most `max_groups` groups of about `group_seconds`. `seconds`: estimated
/// time of each task on all cores of an element.
std::vector<TaskRange> make_groups(const std::vector<double>& seconds, double group_seconds,
                                   size_t max_groups);

/// Splits each task that takes longer than two groups into parts that take one group each.
/// `seconds`: estimated time of each task; afterwards of each task or part.
std::vector<PlannedTask> split_large(const std::vector<PlannedTask>& tasks, double group_seconds,
                                     std::vector<double>& seconds);

/// A submitted farm, as its jobs read it from the batch's folder.
struct Farm {
    BatchRun run;
    FarmOptions options;
    size_t groups = 0;  ///< number of elements of the array
    int attempt = 1;
};

/// A farm before it is submitted.
struct FarmPlan {
    Farm farm;
    std::vector<PlannedTask> tasks;  ///< large pictures in parts
    std::vector<TaskRange> groups;
    std::string array_script, merge_script;  ///< for sbatch
};

/// Makes groups and scripts from the estimated times (see estimate_seconds). Writes nothing.
FarmPlan plan_farm(const std::vector<PlannedTask>& tasks, const BatchRun& run,
                   const FarmOptions& options);

/// Writes groups and scripts below the batch's folder, for submit_farm and the nodes.
void write_farm(const FarmPlan& plan);

/// Submits the groups with the given numbers and the merge job that waits for them; returns the
/// number of the merge job. Throws Error if sbatch fails.
std::string submit_farm(const Farm& farm, const std::vector<size_t>& groups);

/// Runs the tasks of a group that are not done: one element of the array. Returns the exit status
/// of the process: 0, or 75 if Slurm should run the element again.
int run_farm_part(const std::string& folder, size_t group, const std::atomic<int>* interrupts);

/// The result of a merge job.
struct FarmResult {
    bool resubmitted = false;       ///< some tasks had no outcome and were submitted again
    std::vector<Task> tasks;        ///< all tasks
    std::vector<Outcome> outcomes;  ///< in the order of the tasks, as far as they exist
    size_t passed_over = 0;         ///< inputs that are not rendered
    std::string compare_to;
    bool fail_on_change = false;  ///< a picture that changed counts as a failure
};

/// Merges the groups' journals into that of the batch and writes the pictures that were rendered in
/// parts. Submits incomplete groups again while attempts are left.
FarmResult merge_farm(const std::string& folder);

/// Ends the last merge job: records its exit status for wait_for_farm.
void finish_farm(const std::string& folder, int status);

/// Waits until finish_farm was called; returns its status. Throws Error when interrupted, which
/// does not stop the submitted jobs.
int wait_for_farm(const std::string& folder, const std::atomic<int>& interrupts);

}  // namespace sightline
