#include "batch/views.h"

#include "core/suggest.h"
#include "core/text.h"
#include "scene/view_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>

namespace sightline {
namespace {

// The cameras that tasks ask for by name or index, each with one task for each of its assets.
std::map<std::string, std::vector<Task>> find_users(const std::vector<PlannedTask>& tasks) {
    std::map<std::string, std::map<std::string, const Task*>> by_asset;
    for (const PlannedTask& planned : tasks) {
        const auto camera = planned.task.settings.find("camera");
        if (camera != planned.task.settings.end() && !find_view(camera->second))
            by_asset[camera->second].emplace(planned.task.asset, &planned.task);
    }
    std::map<std::string, std::vector<Task>> users;
    for (const auto& [camera, assets] : by_asset)
        for (const auto& [asset, task] : assets) users[camera].push_back(*task);
    return users;
}

[[noreturn]] void refuse(const std::string& camera, size_t assets,
                         std::vector<std::string> candidates) {
    std::ranges::copy(view_names(), std::back_inserter(candidates));
    throw NameError(
        fmt::format("no asset has the camera '{}' ({} searched); a view is one of {}, or the name "
                    "or index of a camera in the file, as in --views front,left{}",
                    camera, assets, describe_views(), did_you_mean(camera, candidates)));
}

}  // namespace

void check_cameras(const std::vector<PlannedTask>& tasks, const BatchRun& run) {
    for (const auto& [camera, users] : find_users(tasks)) {
        bool found = false;
        std::vector<std::string> others;
        // As a rule, one of the first has it.
        for (size_t first = 0; first < users.size() && !found; first += run.jobs) {
            const auto begin = users.begin() + static_cast<std::ptrdiff_t>(first);
            const size_t count = std::min<size_t>(run.jobs, users.size() - first);
            for (const auto& names :
                 list_cameras({begin, begin + static_cast<std::ptrdiff_t>(count)}, run)) {
                found = found || !names || find_choice(*names, camera);
                if (names) others.insert(others.end(), names->begin(), names->end());
            }
        }
        if (!found) refuse(camera, users.size(), std::move(others));
    }
}

}  // namespace sightline
