#pragma once
// What happens in a worker process: one line of JSON in, one line out.
#include "batch/pool.h"
#include "batch/task.h"
#include "output/asset.h"

#include <functional>

namespace sightline {

/// Reads a task's settings as the command line reads its options, without outputs. Throws
/// std::exception with one line on what is wrong.
using ParseSettings = std::function<AssetOptions(const std::string& asset, const Settings&)>;

/// What a worker is asked for.
struct WorkerRequest {
    enum class Kind { render, cameras, measure, sync } kind = Kind::render;
    Task task;
    std::string folder;      ///< the batch's, absolute
    std::string compare_to;  ///< folder of an earlier batch; empty: none
    unsigned threads = 1;
    bool keep_tiles = false;         ///< so that a large picture goes on where it was killed
    std::string earlier;             ///< JSON of this task's outcome in an earlier run; empty: none
    std::vector<std::string> files;  ///< what to sync
};

/// One line each. Cameras are answered by {"cameras": count}, a measurement by {"fixed": seconds,
/// "per_pixel": seconds} of one thread, both 0 where the asset cannot be read. To a request for a
/// sync the answer is empty, or tells why it failed.
std::string to_line(const WorkerRequest& request);
WorkerRequest request_from_line(const std::string& line);

/// Does one task; never throws for the task's fault.
Outcome perform(const WorkerRequest& request, const ParseSettings& parse);

/// A worker's main loop: answers requests from stdin on stdout until the end of input. The process
/// dies with its parent, whose id is `parent`, leaves signals to end it to the parent, and may
/// allocate `memory_mib` (0: no bound). Returns the exit status.
int serve(const ParseSettings& parse, int parent, uint64_t memory_mib);

/// The command that starts a worker of this process: `program` worker --parent … --memory ….
WorkerCommand worker_command(const std::string& program, uint64_t memory_mib);

}  // namespace sightline
