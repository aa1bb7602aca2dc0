#include "batch/contact_sheet.h"

#include "batch/thumbnail.h"
#include "core/files.h"
#include "core/version.h"
#include "output/web_page.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <map>

namespace sightline {

/// The text of contact_sheet.html, compiled in by the build.
extern const char* const contact_sheet_html;

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// The path as a relative URL.
std::string relative_url(const std::string& path) {
    std::string url;
    for (const char c : path) {
        const auto byte = static_cast<unsigned char>(c);
        const bool plain =
            std::isalnum(byte) || std::string_view("-._~/").find(c) != std::string_view::npos;
        url += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
    }
    return url;
}

// The URL of a thumbnail, which the page loads when it is shown; empty if there is none.
std::string thumbnail_url(const fs::path& folder, const std::string& path) {
    std::error_code ignored;
    return fs::is_regular_file(folder / path, ignored) ? relative_url(path) : "";
}

json describe(const fs::path& folder, const Task& task, const Outcome& outcome,
              const std::string& compare_to) {
    json record = to_json(outcome);
    record["name"] = outcome.name;  // for display, hence not as bytes
    record["asset"] = task.asset;
    record["asset_name"] = task.asset_name;
    record["view"] = task.view;
    record["film"] = !task.film.empty();
    record["files"] = json::array();
    for (const std::string& output : task.outputs)
        record["files"].push_back({{"name", output}, {"link", relative_url(output)}});
    record["command"] = render_command(task);
    record["picture"] =
        has_picture(outcome.verdict) ? thumbnail_url(folder, thumbnail_path(task.name)) : "";
    for (const char* unused : {"inputs", "outputs", "key"}) record.erase(unused);
    if (outcome.change.kind == Change::Kind::changed) {
        record["earlierPicture"] = thumbnail_url(folder, outcome.change.earlier);
        record["earlierLink"] =
            relative_url((fs::path(compare_to) / task.outputs[0]).lexically_relative(folder));
    }
    return record;
}

}  // namespace

void write_contact_sheet(const std::string& folder, const std::vector<Task>& tasks,
                         const std::vector<Outcome>& outcomes, const std::string& compare_to) {
    std::map<std::string, const Task*> by_key;
    for (const Task& task : tasks) by_key[task.key()] = &task;
    json records = json::array();
    for (const Outcome& outcome : outcomes)
        if (const auto task = by_key.find(outcome.key); task != by_key.end())
            records.push_back(describe(folder, *task->second, outcome, compare_to));
    write_text((fs::path(folder) / contact_sheet_name).string(),
               fill_page(contact_sheet_html,
                         {{"version", program_version}, {"pictures", std::move(records)}}));
}

}  // namespace sightline
