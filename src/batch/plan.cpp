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

constexpr size_t max_name_bytes = 255;  // of one path component, on all common file systems

// Values of the fields of a name template.
struct NameFields {
    std::string asset, stem, extension, view, variant;
    int frame = 0;
};

std::string without_slashes(std::string text) {
    std::ranges::replace(text, '/', '_');
    return text;
}

std::string expand(const std::string& field, const NameFields& fields) {
    const size_t colon = field.find(':');
    const std::string name = field.substr(0, colon);
    if (name == "frame") {
        size_t width = 0;
        const std::string digits = colon == std::string::npos ? "0" : field.substr(colon + 1);
        const auto [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), width);
        if (error == std::errc() && end == digits.data() + digits.size() && width <= 20)
            return fmt::format("{:0{}}", fields.frame, width);
    } else if (colon == std::string::npos) {
        if (name == "asset") return fields.asset;
        if (name == "stem") return fields.stem;
        if (name == "ext") return fields.extension;
        if (name == "view") return without_slashes(fields.view);
        if (name == "variant") return without_slashes(fields.variant);
    }
    throw Error(fmt::format(
        "name template: unknown field {{{}}}; use {{asset}}, {{stem}}, {{ext}}, {{view}}, "
        "{{frame}}, {{frame:04}} or {{variant}}",
        field));
}

std::string fill_in(const std::string& pattern, const NameFields& fields) {
    std::string result;
    for (size_t at = 0; at < pattern.size();) {
        const size_t open = pattern.find('{', at);
        result += pattern.substr(at, open - at);
        if (open == std::string::npos) break;
        const size_t close = pattern.find('}', open);
        if (close == std::string::npos)
            throw Error(fmt::format("name template '{}': missing }}", pattern));
        result += expand(pattern.substr(open + 1, close - open - 1), fields);
        at = close + 1;
    }
    return result;
}

void check_output_name(const std::string& name, const std::string& asset) {
    const auto refuse = [&](const std::string& why) {
        throw Error(fmt::format("{}: output name '{}' {}", asset, name, why));
    };
    const fs::path path = fs::path(name).lexically_normal();
    if (name.empty() || path.is_absolute() || *path.begin() == ".." || name.ends_with("/"))
        refuse("does not lie below the output folder");
    if (*path.begin() == private_folder) refuse("is reserved for the batch's own files");
    if (name.find('\0') != std::string::npos) refuse("contains a zero byte");
    for (const fs::path& part : path)
        if (part.native().size() > max_name_bytes)
            refuse("has a component longer than 255 bytes; choose a shorter --name");
}

// Makes the tasks of one request: its views times its frames.
class TaskMaker {
  public:
    TaskMaker(const AssetRequest& request, std::vector<Task>& tasks)
        : request_(request),
          spec_(request.spec),
          tasks_(tasks),
          template_(spec_.name.empty() ? default_template(spec_) : spec_.name) {}

    void make() {
        std::vector<View> views = spec_.views;
        for (size_t i = 0; spec_.all_cameras && i < request_.cameras; ++i) {
            views.push_back(camera_view(std::to_string(i)));
            views.back().name = fmt::format("camera{}", i);
        }
        if (views.empty()) views.emplace_back();
        for (const View& view : views) make_view(view);
    }

  private:
    void make_view(const View& view) {
        Settings settings = spec_.settings;
        for (const auto& [option, value] : view.settings) override_setting(settings, option, value);
        if (spec_.turntable) {
            const double start = settings.contains("orbit") ? std::stod(settings["orbit"]) : 0;
            for (int i = 0; i < spec_.turntable; ++i) {
                settings["orbit"] = fmt::format("{}", start + 360.0 * i / spec_.turntable);
                add(view, settings, i);
            }
        } else if (spec_.frames) {
            for (int i = spec_.frames->first; i <= spec_.frames->last; ++i) {
                settings["time"] = fmt::format("{}", i / spec_.frames->fps);
                add(view, settings, i);
            }
        } else {
            add(view, settings, 0);
        }
    }

    void add(const View& view, const Settings& settings, int frame) {
        const fs::path file(request_.asset);
        NameFields fields{request_.name, file.stem(), file.extension(), view.name, "", frame};
        if (!fields.extension.empty()) fields.extension.erase(0, 1);
        if (const auto variant = settings.find("variant"); variant != settings.end())
            fields.variant = variant->second;
        Task task{request_.asset, fill_in(template_, fields), view.name, settings, {}};
        for (const std::string& format : spec_.formats) {
            task.outputs.push_back(task.name + "." + format);
            check_output_name(task.outputs.back(), request_.asset);
        }
        tasks_.push_back(std::move(task));
    }

    const AssetRequest& request_;
    const RenderSpec& spec_;
    std::vector<Task>& tasks_;
    std::string template_;
};

void check_collisions(const std::vector<Task>& tasks) {
    std::map<std::string, const Task*> owners;
    for (const Task& task : tasks)
        for (const std::string& output : task.outputs) {
            const std::string path = fs::path(output).lexically_normal();
            const auto [owner, is_new] = owners.emplace(path, &task);
            if (!is_new)
                throw Error(fmt::format(
                    "{} would be written for both {} and {}; choose different names with --name, "
                    "such as '{{asset}}.{{ext}}_{{view}}', or in a manifest",
                    path, owner->second->asset, task.asset));
        }
}

}  // namespace

View camera_view(const std::string& camera) { return {camera, {{"camera", camera}}}; }

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
        throw Error(fmt::format("'{}' is not a range of frames FIRST..LAST", text));
    if (!(fps > 0)) throw Error("the number of frames per second must be positive");
    return range;
}

std::string default_template(const RenderSpec& spec) {
    std::string pattern = "{asset}";
    if (!spec.views.empty() || spec.all_cameras) pattern += "_{view}";
    if (spec.turntable || spec.frames) pattern += "_{frame:04}";
    return pattern;
}

std::vector<Task> make_tasks(const std::vector<AssetRequest>& requests) {
    std::vector<Task> tasks;
    for (const AssetRequest& request : requests) {
        if (request.spec.turntable && request.spec.frames)
            throw Error(request.asset + ": turntable and frames exclude each other");
        TaskMaker(request, tasks).make();
    }
    check_collisions(tasks);
    return tasks;
}

}  // namespace sightline
