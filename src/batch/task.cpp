#include "batch/task.h"

#include "core/hash.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace sightline {
namespace {

using nlohmann::json;

constexpr std::array verdicts = {"ok", "failed", "crashed", "killed", "timeout", "out-of-memory"};
constexpr std::array changes = {"none", "same", "changed", "added"};

template <class Enum, size_t n>
Enum parse(const std::array<const char*, n>& names, const std::string& text) {
    for (size_t i = 0; i < n; ++i)
        if (text == names[i]) return static_cast<Enum>(i);
    throw json::other_error::create(501, "unknown word '" + text + "'",
                                    static_cast<json*>(nullptr));
}

std::string hex(uint64_t hash) { return fmt::format("{:016x}", hash); }

json files_to_json(const std::vector<FileHash>& files) {
    json list = json::array();
    for (const FileHash& file : files) list.push_back({file.path, hex(file.hash)});
    return list;
}

std::vector<FileHash> files_from_json(const json& list) {
    std::vector<FileHash> files;
    for (const json& file : list)
        files.push_back({file.at(0), std::stoull(file.at(1).get<std::string>(), nullptr, 16)});
    return files;
}

}  // namespace

const char* to_string(Verdict verdict) { return verdicts[static_cast<size_t>(verdict)]; }

bool is_different(const Change& change) {
    return change.kind == Change::Kind::changed || change.kind == Change::Kind::added;
}

std::string Task::key() const {
    // A zero byte ends each piece, so that no two different tasks run together to one text.
    std::string text = std::string(SIGHTLINE_VERSION) + '\0' + asset + '\0';
    for (const auto& [option, value] : settings) text += option + '\0' + value + '\0';
    for (const std::string& output : outputs) text += '\0' + output;
    return hex(hash_text(text));
}

Outcome outcome_of(const Task& task) {
    Outcome outcome;
    outcome.key = task.key();
    outcome.name = task.name;
    return outcome;
}

json to_json(const Task& task) {
    return {{"asset", task.asset},
            {"name", task.name},
            {"view", task.view},
            {"settings", task.settings},
            {"outputs", task.outputs}};
}

Task task_from_json(const json& j) {
    return {j.at("asset"), j.at("name"), j.at("view"), j.at("settings"), j.at("outputs")};
}

json to_json(const Outcome& o) {
    json j = {{"key", o.key},
              {"name", o.name},
              {"verdict", to_string(o.verdict)},
              {"inputs", files_to_json(o.inputs)},
              {"outputs", files_to_json(o.outputs)},
              {"seconds", o.seconds},
              {"rays", o.rays},
              {"memory", o.memory}};
    if (!o.message.empty()) j["message"] = o.message;
    if (!o.log.empty()) j["log"] = o.log;
    if (!o.warnings.empty()) j["warnings"] = o.warnings;
    if (o.skipped) j["skipped"] = true;
    const Change& d = o.change;
    if (d.kind != Change::Kind::none)
        j["change"] = {{"kind", changes[static_cast<size_t>(d.kind)]},
                       {"flip", d.flip},
                       {"earlier", d.earlier},
                       {"message", d.message}};
    return j;
}

Outcome outcome_from_json(const json& j) {
    Outcome o;
    o.key = j.at("key");
    o.name = j.at("name");
    o.verdict = parse<Verdict>(verdicts, j.at("verdict"));
    o.message = j.value("message", "");
    o.log = j.value("log", "");
    o.warnings = j.value("warnings", std::vector<std::string>());
    o.inputs = files_from_json(j.at("inputs"));
    o.outputs = files_from_json(j.at("outputs"));
    o.seconds = j.at("seconds");
    o.rays = j.at("rays");
    o.memory = j.at("memory");
    o.skipped = j.value("skipped", false);
    if (const auto d = j.find("change"); d != j.end())
        o.change = {parse<Change::Kind>(changes, d->at("kind")), d->at("flip"), d->at("earlier"),
                    d->at("message")};
    return o;
}

std::string shell_quoted(const std::string& text) {
    const bool plain = !text.empty() && std::ranges::all_of(text, [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) ||
               std::string_view("-_./=,:").find(c) != std::string_view::npos;
    });
    if (plain) return text;
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

std::string render_command(const Task& task) {
    std::string command = fmt::format("sightline render {}", shell_quoted(task.asset));
    const auto add = [&](const std::string& option, const std::string& value) {
        command += ' ';
        command += shell_quoted(fmt::format("--{}{}{}", option, value.empty() ? "" : "=", value));
    };
    for (const auto& [option, value] : task.settings) add(option, value);
    for (const std::string& output : task.outputs) add("output", output);
    return command;
}

std::string printable(const std::string& text) {
    std::string result;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x20 || byte == 0x7f) {
            result += c == '\n' ? "\\n" : fmt::format("\\x{:02x}", byte);
        } else {
            result += c;
        }
    }
    return result;
}

}  // namespace sightline
