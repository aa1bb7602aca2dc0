#include "batch/plan.h"

#include "batch/thumbnail.h"
#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr size_t longest_name = 255;  // bytes of one component, on all common file systems

// What a template may speak of.
struct Names {
    std::string asset, stem, extension, view, variant;
    int frame = 0;
};

std::string without_slashes(std::string text) {
    std::ranges::replace(text, '/', '_');
    return text;
}

std::string expand(const std::string& field, const Names& names) {
    const size_t colon = field.find(':');
    const std::string name = field.substr(0, colon);
    if (name == "frame") {
        size_t width = 0;
        const std::string digits = colon == std::string::npos ? "0" : field.substr(colon + 1);
        const auto [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), width);
        if (error == std::errc() && end == digits.data() + digits.size() && width <= 20)
            return fmt::format("{:0{}}", names.frame, width);
    } else if (colon == std::string::npos) {
        if (name == "asset") return names.asset;
        if (name == "stem") return names.stem;
        if (name == "ext") return names.extension;
        if (name == "view") return without_slashes(names.view);
        if (name == "variant") return without_slashes(names.variant);
    }
    throw Error(
        fmt::format("name template: {{{}}} is none of {{asset}}, {{stem}}, {{ext}}, "
                    "{{view}}, {{frame}}, {{frame:04}}, {{variant}}",
                    field));
}

std::string fill_in(const std::string& pattern, const Names& names) {
    std::string result;
    for (size_t at = 0; at < pattern.size();) {
        const size_t open = pattern.find('{', at);
        result += pattern.substr(at, open - at);
        if (open == std::string::npos) break;
        const size_t close = pattern.find('}', open);
        if (close == std::string::npos)
            throw Error(fmt::format("name template '{}': a {{ is not closed", pattern));
        result += expand(pattern.substr(open + 1, close - open - 1), names);
        at = close + 1;
    }
    return result;
}

void check_output_name(const std::string& name, const std::string& asset) {
    const auto refuse = [&](const std::string& why) {
        throw Error(fmt::format("{}: its picture '{}' {}", asset, name, why));
    };
    const fs::path path = fs::path(name).lexically_normal();
    if (name.empty() || path.is_absolute() || *path.begin() == ".." || name.ends_with("/"))
        refuse("is no file below the output folder");
    if (*path.begin() == private_folder) refuse("is where the batch keeps its own files");
    if (name.find('\0') != std::string::npos) refuse("has a name with a zero byte");
    for (const fs::path& part : path)
        if (part.native().size() > longest_name)
            refuse("has a name of more than 255 bytes: choose a shorter --name");
}

// The views times the frames of one order.
class TaskMaker {
  public:
    TaskMaker(const Order& order, std::vector<Task>& tasks)
        : order_(order),
          set_(order.pictures),
          tasks_(tasks),
          template_(set_.name.empty() ? default_template(set_) : set_.name) {}

    void make() {
        std::vector<View> views = set_.views;
        for (size_t i = 0; set_.all_cameras && i < order_.cameras; ++i) {
            views.push_back(view_of_camera(std::to_string(i)));
            views.back().name = fmt::format("camera{}", i);
        }
        if (views.empty()) views.emplace_back();
        for (const View& view : views) make_view(view);
    }

  private:
    void make_view(const View& view) {
        Settings settings = set_.settings;
        for (const auto& [option, value] : view.settings) override_setting(settings, option, value);
        if (set_.turntable) {
            const double start = settings.contains("orbit") ? std::stod(settings["orbit"]) : 0;
            for (int i = 0; i < set_.turntable; ++i) {
                settings["orbit"] = fmt::format("{}", start + 360.0 * i / set_.turntable);
                add(view, settings, i);
            }
        } else if (set_.frames) {
            for (int i = set_.frames->first; i <= set_.frames->last; ++i) {
                settings["time"] = fmt::format("{}", i / set_.frames->fps);
                add(view, settings, i);
            }
        } else {
            add(view, settings, 0);
        }
    }

    void add(const View& view, const Settings& settings, int frame) {
        const fs::path file(order_.asset);
        Names names{order_.name, file.stem(), file.extension(), view.name, "", frame};
        if (!names.extension.empty()) names.extension.erase(0, 1);
        if (const auto variant = settings.find("variant"); variant != settings.end())
            names.variant = variant->second;
        Task task{order_.asset, fill_in(template_, names), view.name, settings, {}};
        for (const std::string& format : set_.formats) {
            task.outputs.push_back(task.name + "." + format);
            check_output_name(task.outputs.back(), order_.asset);
        }
        tasks_.push_back(std::move(task));
    }

    const Order& order_;
    const PictureSet& set_;
    std::vector<Task>& tasks_;
    std::string template_;
};

void refuse_collisions(const std::vector<Task>& tasks) {
    std::map<std::string, const Task*> owners;
    for (const Task& task : tasks)
        for (const std::string& output : task.outputs) {
            const std::string path = fs::path(output).lexically_normal();
            const auto [owner, is_new] = owners.emplace(path, &task);
            if (!is_new)
                throw Error(
                    fmt::format("{} would be written for both {} and {}: give them "
                                "different names with --name (such as "
                                "'{{asset}}.{{ext}}_{{view}}') or in a manifest",
                                path, owner->second->asset, task.asset));
        }
}

}  // namespace

View view_of_camera(const std::string& camera) { return {camera, {{"camera", camera}}}; }

void override_setting(Settings& settings, const std::string& name, const std::string& value) {
    if (name == "error") settings.erase("samples");
    if (name == "samples") settings.erase("error");
    settings[name] = value;
}

std::string absolute_environment(const std::string& env, const std::string& folder) {
    if (env == "studio" || env == "none") return env;
    return (fs::path(folder) / env).lexically_normal();
}

FrameRange parse_frames(const std::string& text, double fps) {
    FrameRange range{0, 0, fps};
    char rest = 0;
    if (std::sscanf(text.c_str(), "%d..%d%c", &range.first, &range.last, &rest) != 2 ||
        range.first < 0 || range.last < range.first || range.last > 10'000'000)
        throw Error(fmt::format("'{}' is no range of frames FIRST..LAST", text));
    if (!(fps > 0)) throw Error("the frames a second must be more than 0");
    return range;
}

std::string default_template(const PictureSet& pictures) {
    std::string pattern = "{asset}";
    if (!pictures.views.empty() || pictures.all_cameras) pattern += "_{view}";
    if (pictures.turntable || pictures.frames) pattern += "_{frame:04}";
    return pattern;
}

std::vector<Task> make_tasks(const std::vector<Order>& orders) {
    std::vector<Task> tasks;
    for (const Order& order : orders) {
        if (order.pictures.turntable && order.pictures.frames)
            throw Error(order.asset + ": a turntable and frames cannot go together");
        TaskMaker(order, tasks).make();
    }
    refuse_collisions(tasks);
    return tasks;
}

}  // namespace sightline
