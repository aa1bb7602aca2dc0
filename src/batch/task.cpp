#include "batch/task.h"

#include "core/hash.h"
#include "core/text.h"
#include "core/version.h"
#include "output/statistics.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <sstream>
#include <stdexcept>

namespace sightline {
namespace {

using nlohmann::json;

constexpr std::array verdicts = {
    "ok",      "drawn-with-faults", "failed",          "crashed", "killed",
    "timeout", "out-of-memory",     "output-is-input", "empty",   "black"};
constexpr std::array changes = {"none", "same", "changed", "added"};

template <class Enum, size_t n>
Enum parse(const std::array<const char*, n>& names, const std::string& text) {
    for (size_t i = 0; i < n; ++i)
        if (text == names[i]) return static_cast<Enum>(i);
    throw json::other_error::create(501, "unknown value '" + text + "'",
                                    static_cast<json*>(nullptr));
}

std::string hex(uint64_t hash) { return fmt::format("{:016x}", hash); }

json files_to_json(const std::vector<FileHash>& files) {
    json list = json::array();
    for (const FileHash& file : files) list.push_back({bytes_to_json(file.path), hex(file.hash)});
    return list;
}

std::vector<FileHash> files_from_json(const json& list) {
    std::vector<FileHash> files;
    for (const json& file : list)
        files.push_back(
            {bytes_from_json(file.at(0)), std::stoull(file.at(1).get<std::string>(), nullptr, 16)});
    return files;
}

}  // namespace

const char* to_string(TaskVerdict verdict) { return verdicts[static_cast<size_t>(verdict)]; }

bool is_blank(TaskVerdict verdict) {
    return verdict == TaskVerdict::empty || verdict == TaskVerdict::black;
}

bool has_picture(TaskVerdict verdict) {
    return verdict == TaskVerdict::ok || verdict == TaskVerdict::drawn_with_faults ||
           is_blank(verdict);
}

bool is_different(const Change& change) {
    return change.kind == Change::Kind::changed || change.kind == Change::Kind::added;
}

std::string Task::key() const {
    // A zero byte after each piece keeps the texts of different tasks different.
    std::string text = std::string(program_version) + '\0' + asset + '\0';
    for (const Settings* options : {&settings, &film})
        for (const auto& [option, value] : *options) text += option + '\0' + value + '\0';
    for (const std::string& output : outputs) text += '\0' + output;
    if (parts > 1) text += fmt::format("\n{}/{}", part, parts);
    return hex(hash_text(text));
}

Outcome make_outcome(const Task& task) {
    Outcome outcome;
    outcome.key = task.key();
    outcome.name = task.name;
    outcome.asset = task.asset;
    outcome.asset_name = task.asset_name;
    return outcome;
}

json bytes_to_json(const std::string& text) {
    if (is_utf8(text)) return text;
    return std::vector<uint8_t>(text.begin(), text.end());
}

std::string bytes_from_json(const json& j) {
    if (j.is_string()) return j;
    const auto bytes = j.get<std::vector<uint8_t>>();
    return {bytes.begin(), bytes.end()};
}

json to_json(const Task& task) {
    json settings = json::object(), film = json::object(), outputs = json::array();
    for (const auto& [option, value] : task.settings) settings[option] = bytes_to_json(value);
    for (const auto& [option, value] : task.film) film[option] = value;
    for (const std::string& output : task.outputs) outputs.push_back(bytes_to_json(output));
    json j = {{"asset", bytes_to_json(task.asset)},
              {"asset_name", bytes_to_json(task.asset_name)},
              {"name", bytes_to_json(task.name)},
              {"view", bytes_to_json(task.view)},
              {"settings", settings},
              {"outputs", outputs}};
    if (!film.empty()) j["film"] = film;
    if (task.parts > 1) j["part"] = {task.part, task.parts};
    return j;
}

Task task_from_json(const json& j) {
    Task task;
    task.asset = bytes_from_json(j.at("asset"));
    task.asset_name = bytes_from_json(j.at("asset_name"));
    task.name = bytes_from_json(j.at("name"));
    task.view = bytes_from_json(j.at("view"));
    for (const auto& [option, value] : j.at("settings").items())
        task.settings[option] = bytes_from_json(value);
    if (const auto film = j.find("film"); film != j.end())
        for (const auto& [option, value] : film->items()) task.film[option] = value;
    for (const json& output : j.at("outputs")) task.outputs.push_back(bytes_from_json(output));
    if (const auto part = j.find("part"); part != j.end())
        task.part = part->at(0), task.parts = part->at(1);
    return task;
}

json to_json(const Outcome& o) {
    json j = {{"key", o.key},
              {"name", bytes_to_json(o.name)},
              {"asset", bytes_to_json(o.asset)},
              {"asset_name", bytes_to_json(o.asset_name)},
              {"verdict", to_string(o.verdict)},
              {"inputs", files_to_json(o.inputs)},
              {"outputs", files_to_json(o.outputs)},
              {"seconds", o.seconds},
              {"rays", o.rays},
              {"memory", o.memory}};
    if (!o.stages.empty()) j["stages"] = o.stages;
    for (const std::string& path : o.staged) j["staged"].push_back(bytes_to_json(path));
    if (!o.message.empty()) j["message"] = o.message;
    if (!o.log.empty()) j["log"] = o.log;
    if (!o.warnings.empty()) j["warnings"] = o.warnings;
    if (o.fault_count > 0) j["fault_count"] = o.fault_count;
    if (!o.faults.empty()) j["faults"] = faults_json(o.faults);
    if (o.skipped) j["skipped"] = true;
    const Change& d = o.change;
    if (d.kind != Change::Kind::unknown)
        j["change"] = {{"kind", changes[static_cast<size_t>(d.kind)]},
                       {"flip", d.flip},
                       {"earlier", d.earlier},
                       {"message", d.message}};
    return j;
}

Outcome outcome_from_json(const json& j) {
    Outcome o;
    o.key = j.at("key");
    o.name = bytes_from_json(j.at("name"));
    o.asset = bytes_from_json(j.value("asset", json("")));  // an older journal has none
    o.asset_name = bytes_from_json(j.value("asset_name", json("")));
    o.verdict = parse<TaskVerdict>(verdicts, j.at("verdict"));
    o.message = j.value("message", "");
    o.log = j.value("log", "");
    o.warnings = j.value("warnings", std::vector<std::string>());
    o.fault_count = j.value("fault_count", uint64_t{0});
    for (const json& fault : j.value("faults", json::array()))
        o.faults.push_back({fault.at("key"), fault.at("place"), fault.at("text")});
    o.inputs = files_from_json(j.at("inputs"));
    o.outputs = files_from_json(j.at("outputs"));
    for (const json& path : j.value("staged", json::array()))
        o.staged.push_back(bytes_from_json(path));
    o.seconds = j.at("seconds");
    o.stages = j.value("stages", std::map<std::string, double>());
    o.rays = j.at("rays");
    o.memory = j.at("memory");
    o.skipped = j.value("skipped", false);
    if (const auto d = j.find("change"); d != j.end())
        o.change = {parse<Change::Kind>(changes, d->at("kind")), d->at("flip"), d->at("earlier"),
                    d->at("message")};
    return o;
}

std::set<std::string> data_layers_of(const Settings& settings) {
    std::set<std::string> layers;
    const auto data = settings.find("data");
    std::istringstream list(data == settings.end() ? "" : data->second);
    for (std::string layer; std::getline(list, layer, ',');) layers.insert(layer);
    return layers;
}

std::string render_command(const Task& task) {
    std::string command = fmt::format("sightline render {}", shell_quoted(task.asset));
    const auto add = [&](const std::string& option, const std::string& value) {
        command += ' ';
        command += shell_quoted(fmt::format("--{}{}{}", option, value.empty() ? "" : "=", value));
    };
    for (const auto& [option, value] : task.settings) add(option, value);
    for (const auto& [option, value] : task.film) add(option, value);
    const size_t pictures = task.outputs.size() - data_layers_of(task.settings).size();
    for (size_t i = 0; i < pictures; ++i) add("output", task.outputs[i]);
    return command;
}

}  // namespace sightline
