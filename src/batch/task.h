#pragma once
// One picture to render and the outcome: plain data with a JSON form.
#include "scene/gltf/faults.h"

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <vector>

namespace sightline {

/// Options of `sightline render` by name, without dashes; the value of a flag is empty. Thus a task
/// is a command line, and the batch depends on no particular option.
using Settings = std::map<std::string, std::string>;

/// One run of `render` within a batch.
struct Task {
    std::string asset;       ///< absolute path of the .gltf or .glb
    std::string asset_name;  ///< {asset} in the names of its pictures
    std::string name;        ///< path of the picture below the batch's folder, no extension
    std::string view;        ///< name of the view, for the contact sheet
    Settings settings;
    /// Relative to the batch's folder: the pictures, then those of data_layers_of.
    std::vector<std::string> outputs;
    /// A part of a large picture on a farm renders every `parts`th tile, beginning with number
    /// `part`, and writes no outputs.
    unsigned part = 0, parts = 1;
    /// Of a film: the options that say its frames, `turntable` or `frames`, and `fps`; else empty.
    Settings film = {};

    /// A hash of everything that may change the outputs, except the contents of files.
    std::string key() const;
};

/// How a task ended.
enum class TaskVerdict {
    ok,
    drawn_with_faults,  ///< the picture was made, without what the asset's faults cost
    failed,
    crashed,
    killed,
    timeout,
    out_of_memory,
    output_is_input,
    empty,
    black
};

/// "ok", "drawn-with-faults", "failed", "crashed", "killed", "timeout", "out-of-memory",
/// "output-is-input", "empty", "black".
const char* to_string(TaskVerdict verdict);

/// Whether the picture was made, although it may show nothing.
bool has_picture(TaskVerdict verdict);

/// Whether the picture was made and shows nothing.
bool is_blank(TaskVerdict verdict);

/// A file and the hash of its content.
struct FileHash {
    std::string path;
    uint64_t hash = 0;
    bool operator==(const FileHash&) const = default;
};

/// The difference between a picture and that of an earlier run.
struct Change {
    enum class Kind {
        unknown,
        same,
        changed,
        added
    } kind = Kind::unknown;  ///< unknown: not compared
    double flip = 0;         ///< mean FLIP, in [0,1]
    std::string earlier;     ///< path of the earlier picture's thumbnail, below the batch's folder
    std::string message;     ///< why FLIP could not be computed; otherwise empty
};

/// True if the earlier run had a different picture or none.
bool is_different(const Change& change);

/// The result of a task.
struct Outcome {
    std::string key;         ///< the task's
    std::string name;        ///< the task's
    std::string asset;       ///< the task's
    std::string asset_name;  ///< the task's
    TaskVerdict verdict = TaskVerdict::ok;
    std::string message;  ///< the reason if not ok; one line
    std::string log;      ///< the end of the worker's stderr if there is no picture
    std::vector<std::string> warnings;
    std::vector<FoundFault> faults;  ///< of the asset, as in Scene
    uint64_t fault_count = 0;
    std::vector<FileHash> inputs;   ///< every file that was read; absolute paths
    std::vector<FileHash> outputs;  ///< relative to the batch's folder, the thumbnail last
    /// Temporary files of the pictures until they are synced, relative to the batch's folder, in
    /// the order of the outputs. Empty in a journal.
    std::vector<std::string> staged;
    double seconds = 0;
    std::map<std::string, double> stages;  ///< seconds by stage: see stages_of
    uint64_t rays = 0;
    uint64_t memory = 0;  ///< peak of the worker process during this task, bytes
    Change change;
    bool skipped = false;  ///< done by an earlier run and unchanged
};

/// The layers that the option `data` asks for.
std::set<std::string> data_layers_of(const Settings& settings);

/// The shell command that renders this task alone.
std::string render_command(const Task& task);

/// An empty outcome with the task's key, name and asset.
Outcome make_outcome(const Task& task);

/// JSON strings are Unicode, but file names may be any bytes. Text that is not UTF-8 becomes an
/// array of its bytes.
nlohmann::json bytes_to_json(const std::string& text);
std::string bytes_from_json(const nlohmann::json& json);

nlohmann::json to_json(const Task& task);
nlohmann::json to_json(const Outcome& outcome);
/// Both throw nlohmann::json::exception unless to_json made `json`.
Task task_from_json(const nlohmann::json& json);
Outcome outcome_from_json(const nlohmann::json& json);

}  // namespace sightline
