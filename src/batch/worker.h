#pragma once
// A worker process: reads requests and writes responses, one line of JSON each.
#include "batch/pool.h"
#include "batch/task.h"
#include "output/options.h"

#include <functional>

namespace sightline {

/// Parses a task's settings like options on the command line; leaves the outputs empty. Throws
/// std::exception with a one-line message.
using ParseSettings = std::function<RenderCommand(const std::string& asset, const Settings&)>;

/// A request to a worker.
struct WorkerRequest {
    enum class Kind { render, cameras, measure, sync } kind = Kind::render;
    Task task;
    std::string folder;      ///< the batch's, absolute
    std::string compare_to;  ///< folder of an earlier batch; empty: none
    unsigned threads = 1;
    bool keep_tiles = false;  ///< keep finished tiles, to resume a large picture after a kill
    std::string earlier;      ///< JSON of the task's outcome in an earlier run; empty: none
    std::vector<std::string> files;  ///< to sync
};

/// The request as one line. The responses are: for `render` an Outcome; for `cameras`
/// {"cameras": count}; for `measure` {"fixed": seconds, "per_pixel": seconds} of one thread, all 0
/// if the asset cannot be read; for `sync` an empty line, or the reason of the failure.
std::string to_line(const WorkerRequest& request);
WorkerRequest request_from_line(const std::string& line);

/// Runs one task. Errors of the task are in the outcome, not thrown.
Outcome run_task(const WorkerRequest& request, const ParseSettings& parse);

/// A worker's main loop: reads requests from stdin and writes responses to stdout until the end of
/// input. The process is killed when its parent, whose id is `parent`, dies; ignores SIGINT and
/// SIGTERM; and may allocate `memory_mib` (0: unlimited). Returns the exit status.
int run_worker(const ParseSettings& parse, int parent, uint64_t memory_mib);

/// The command that starts a worker of this process: PROGRAM worker --parent PID --memory MIB.
WorkerCommand worker_command(const std::string& program, uint64_t memory_mib);

}  // namespace sightline
