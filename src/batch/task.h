#pragma once
// One picture to make, and what became of it: plain data, with its JSON form.
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace sightline {

/// Options of `sightline render` by name, without dashes; a flag's value is empty. So a task is
/// a command line, and a manifest needs no options of its own.
using Settings = std::map<std::string, std::string>;

/// One run of `render` within a batch.
struct Task {
    std::string asset;  ///< absolute path of the .gltf or .glb
    std::string name;   ///< of the picture: its path below the batch's folder, without ending
    std::string view;   ///< for the contact sheet
    Settings settings;
    std::vector<std::string> outputs;  ///< relative to the batch's folder
    /// Of a large picture on a farm: every `parts`th tile from the `part`th on, and no outputs.
    unsigned part = 0, parts = 1;

    /// Changes with anything but the files' contents that may change the outputs.
    std::string key() const;
};

/// How a task ended.
enum class TaskVerdict { ok, failed, crashed, killed, timeout, out_of_memory };

/// "ok", "failed", "crashed", "killed", "timeout", "out-of-memory".
const char* to_string(TaskVerdict verdict);

/// A file by its content.
struct FileHash {
    std::string path;
    uint64_t hash = 0;
    bool operator==(const FileHash&) const = default;
};

/// How far a picture is from the one of an earlier run.
struct Change {
    enum class Kind { none, same, changed, added } kind = Kind::none;  ///< none: not compared
    double flip = 0;                                                   ///< mean FLIP, in [0,1]
    std::string earlier;  ///< path of the earlier picture's thumbnail, below the batch's folder
    std::string message;  ///< why it could not be measured
};

/// Whether the earlier run had another picture, or none.
bool is_different(const Change& change);

/// What became of a task.
struct Outcome {
    std::string key;   ///< the task's
    std::string name;  ///< the task's
    TaskVerdict verdict = TaskVerdict::ok;
    std::string message;  ///< the reason where not ok; one line
    std::string log;      ///< the last lines of the worker where not ok
    std::vector<std::string> warnings;
    std::vector<FileHash> inputs;   ///< every file that was read, absolute
    std::vector<FileHash> outputs;  ///< relative to the batch's folder, the thumbnail last
    /// Where the pictures are until they are synced: relative, in the order of the outputs. Empty
    /// in a journal.
    std::vector<std::string> staged;
    double seconds = 0;
    uint64_t rays = 0;
    uint64_t memory = 0;  ///< peak of the worker's process so far, bytes
    Change change;
    bool skipped = false;  ///< was done by an earlier run and is unchanged
};

/// The text as one word of a bash command, in UTF-8 whatever the text is.
std::string shell_quoted(const std::string& text);

/// The command that renders the task alone, for a shell.
std::string render_command(const Task& task);

/// An outcome of this task with nothing in it yet.
Outcome make_outcome(const Task& task);

/// JSON's texts are Unicode, but the name of a file may be any bytes: those that are no UTF-8
/// are kept as an array of numbers.
nlohmann::json bytes_to_json(const std::string& text);
std::string bytes_from_json(const nlohmann::json& json);

nlohmann::json to_json(const Task& task);
nlohmann::json to_json(const Outcome& outcome);
/// Both throw nlohmann::json::exception where `json` is not what to_json made.
Task task_from_json(const nlohmann::json& json);
Outcome outcome_from_json(const nlohmann::json& json);

}  // namespace sightline
