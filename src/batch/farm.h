#pragma once
// A batch spread over the nodes of a Slurm cluster: one job array, and a job that joins its parts.
#include "batch/batch.h"

namespace sightline {

/// How to run a batch on a farm.
struct FarmOptions {
    std::string program;               ///< path of sightline on every node
    std::vector<std::string> options;  ///< further lines for sbatch, such as --partition=short
    double group_seconds = 120;        ///< what one element of the array should take
    size_t max_groups = 1000;          ///< most elements of an array (Slurm's MaxArraySize is 1001)
    size_t at_once = 0;                ///< most elements that run at once; 0: any number
    int attempts = 3;                  ///< how often what is missing is submitted
    uint64_t memory_mib = 0;           ///< of a worker; 0: any
    bool fail_on_change = false;       ///< see FarmResult
};

/// Consecutive tasks that one element of the array does.
struct TaskRange {
    size_t first = 0, count = 0;
};

/// Splits tasks into groups of about `group_seconds`, but not more than `max_groups`. `seconds`:
/// how long each task takes on a whole element.
std::vector<TaskRange> make_groups(const std::vector<double>& seconds, double group_seconds,
                                   size_t max_groups);

/// A batch on a farm.
struct Farm {
    BatchRun run;
    FarmOptions options;
    std::vector<PlannedTask> tasks;  ///< large pictures in parts; not read back from the folder
    std::vector<TaskRange> groups;   ///< read back from the folder: their number alone
    int attempt = 1;
    std::string array_script, merge_script;  ///< what sbatch is given
};

/// Tasks that would take more than two groups' time, in parts that take one each. `seconds`: of
/// each task, adapted to the parts.
std::vector<PlannedTask> split_large(const std::vector<PlannedTask>& tasks, double group_seconds,
                                     std::vector<double>& seconds);

/// Decides groups and scripts; tries a few pictures at a small size, but writes nothing.
Farm plan_farm(const std::vector<PlannedTask>& tasks, const BatchRun& run,
               const FarmOptions& options);

/// Writes groups and scripts below the batch's folder, for submit_farm and the nodes.
void write_farm(const Farm& farm);

/// Submits the groups (their numbers) and the merge job that waits for them; gives the merge job's
/// number. Throws Error where sbatch fails.
std::string submit_farm(const Farm& farm, const std::vector<size_t>& groups);

/// One element of the array: does what is not done of its group. Gives the process' exit status:
/// 0, or 75 where it should be tried again elsewhere.
int run_farm_part(const std::string& folder, size_t group, const std::atomic<int>* interrupts);

/// What the merge job found.
struct FarmResult {
    bool resubmitted = false;       ///< something was missing and is under way again
    std::vector<Task> tasks;        ///< all
    std::vector<Outcome> outcomes;  ///< in the order of the tasks, as far as they are there
    std::string compare_to;
    bool fail_on_change = false;  ///< a picture that changed counts as a failure
};

/// Ends the merge job: leaves its exit status for wait_for_farm.
void finish_farm(const std::string& folder, int status);

/// Waits until the merge job has ended for good; gives its exit status. Throws Error when
/// interrupted; the farm goes on.
int wait_for_farm(const std::string& folder, const std::atomic<int>& interrupts);

/// Joins the parts' journals into the batch's, and the parts of large pictures. What is missing is
/// submitted again while attempts are left.
FarmResult merge_farm(const std::string& folder);

}  // namespace sightline
