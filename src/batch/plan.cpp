#include "batch/plan.h"

#include "core/error.h"
#include "output/data_layers.h"
#include "output/environment_cache.h"
#include "output/movie.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>

namespace sightline {
namespace {

namespace fs = std::filesystem;

bool is_movie_format(const std::string& format) { return is_movie("film." + format); }

bool can_be_movie_format(const std::string& format) { return can_be_movie("film." + format); }

const NameFields example_fields{"asset", "glb", "view", "variant", 0};

std::string template_of(const RenderSpec& spec) {
    return spec.name.empty() ? default_template(spec) : spec.name;
}

// Adds the pictures of one view: its frames or turntable steps.
void add_pictures(const RenderSpec& spec, const View& view, std::vector<PictureRequest>& pictures) {
    Settings settings = spec.settings;
    for (const auto& [option, value] : view.settings) override_setting(settings, option, value);
    // All assets alike: some files have a camera, others none.
    if (!spec.use_file_cameras && !settings.contains("camera") && !settings.contains("look-from") &&
        !settings.contains("look-at"))
        settings["camera"] = "fit";
    if (const auto& [count, at] = spec.turntable; count) {
        const double start = settings.contains("orbit") ? std::stod(settings["orbit"]) : 0;
        if (at) settings["camera"] = fmt::format("{}/{}", at->azimuth, at->elevation);
        for (int i = 0; i < count; ++i) {
            settings["orbit"] = fmt::format("{}", start + 360.0 * i / count);
            pictures.push_back({view.name, i, settings});
        }
    } else if (spec.frames) {
        if (!settings.contains("frame-each"))
            settings["frame-for"] =
                fmt::format("{}..{}@{}", spec.frames->first, spec.frames->last, spec.frames->fps);
        for (int i = spec.frames->first; i <= spec.frames->last; ++i) {
            settings["time"] = fmt::format("{}", i / spec.frames->fps);
            pictures.push_back({view.name, i, settings});
        }
    } else {
        pictures.push_back({view.name, 0, settings});
    }
}

// The options that say the frames of a film; where the turntable stands is in its view's settings.
Settings film_of(const RenderSpec& spec) {
    const double fps = spec.frames ? spec.frames->fps : spec.fps;
    Settings film = {{"fps", fmt::format("{}", fps)}};
    if (spec.frames)
        film["frames"] = fmt::format("{}..{}", spec.frames->first, spec.frames->last);
    else
        film["turntable"] = fmt::format("{}", spec.turntable.count);
    return film;
}

// One for each task.
std::vector<PictureRequest> tasks_of(const RenderSpec& spec, size_t cameras) {
    if (!makes_films(spec)) return pictures_of(spec, cameras);
    RenderSpec views = spec;
    views.turntable = {};
    views.frames.reset();
    std::vector<PictureRequest> films = pictures_of(views, cameras);
    if (const auto& at = spec.turntable.start)
        for (PictureRequest& film : films)
            film.settings["camera"] = fmt::format("{}/{}", at->azimuth, at->elevation);
    return films;
}

void check_films(const RenderSpec& spec) {
    if (!makes_films(spec)) return;
    if (!std::ranges::all_of(spec.formats, can_be_movie_format))
        throw NameError(
            "films and pictures are made by two runs; give --format either films (mp4, "
            "webm, gif, webp) or pictures");
    if (!spec.turntable.count && !spec.frames)
        throw NameError(
            "a film needs --turntable N or --frames FIRST..LAST; without, give --format a "
            "picture's, "
            "such as png");
    if (has_field(spec.name, "frame"))
        throw NameError(
            fmt::format("'{}': a film has all frames; leave {{frame}} out of its name, as in "
                        "'{{asset}}_{{view}}'",
                        spec.name));
    if (spec.settings.contains("data"))
        throw NameError("--data is of pictures; films have no layers");
}

// The task of a picture under a name of its asset.
Task make_task(const AssetRequest& request, const std::string& name, PictureRequest&& picture) {
    const RenderSpec& spec = request.spec;
    Task task;
    task.asset = request.asset;
    task.asset_name = name;
    if (makes_films(spec)) task.film = film_of(spec);
    std::vector<std::string> endings = spec.formats;
    for (const std::string& layer : data_layers_of(picture.settings))
        endings.push_back(layer + ".png");
    task.name = output_name(fill_in(template_of(spec), name_fields(request.asset, name, picture)),
                            *std::ranges::max_element(endings, {}, &std::string::size));
    task.view = std::move(picture.view);
    task.settings = std::move(picture.settings);
    for (const std::string& format : spec.formats) task.outputs.push_back(task.name + "." + format);
    if (!task.film.empty()) return task;
    for (const std::string& file : data_paths(task.outputs[0], data_layers_of(task.settings)))
        task.outputs.push_back(file);
    return task;
}

[[noreturn]] void refuse_template(const RenderSpec& spec, const std::string& what,
                                  const std::string& field) {
    throw NameError(fmt::format("'{}' gives {} the same name; add {}, as in '{}'",
                                template_of(spec), what, field,
                                with_field(template_of(spec), field)));
}

// Finds names for the pictures of all requests.
class Planner {
  public:
    Planner(const std::vector<AssetRequest>& requests, const KnownNames& known)
        : requests_(requests), known_(known), tasks_(requests.size()) {
        for (const auto& [asset, names] : known)
            for (const std::string& name : names) name_owners_.emplace(name, asset);
        std::vector<NamedAsset> assets;
        for (const AssetRequest& r : requests) assets.push_back({r.asset, r.name});
        names_ = mirrored_names(assets, known);
    }

    std::vector<Task> plan() {
        for (size_t i = 0; i < requests_.size(); ++i) place_by_known_name(i);
        // Before others, which are to be told apart, can take the names.
        for (size_t i = 0; i < requests_.size(); ++i)
            if (tasks_[i].empty()) place(i, names_[i]);
        std::vector<Task> all;
        for (size_t i = 0; i < requests_.size(); ++i) {
            if (tasks_[i].empty()) place_elsewhere(i);
            std::ranges::move(tasks_[i], std::back_inserter(all));
        }
        return all;
    }

  private:
    void place_by_known_name(size_t i) {
        const auto known = known_.find(requests_[i].asset);
        if (known == known_.end()) return;
        for (const std::string& name : known->second)
            if (place(i, name)) return;
    }

    // Makes the tasks of a request if their outputs belong to no others.
    bool place(size_t i, const std::string& name) {
        const AssetRequest& request = requests_[i];
        const auto owner = name_owners_.find(name);
        if (owner != name_owners_.end() && owner->second != request.asset) return false;
        std::vector<Task> tasks;
        for (PictureRequest& picture : tasks_of(request.spec, request.cameras))
            tasks.push_back(make_task(request, name, std::move(picture)));
        std::set<std::string> outputs;
        for (const Task& task : tasks)
            for (const std::string& output : task.outputs) {
                if (!outputs.insert(output).second)
                    throw NameError(fmt::format("{}: two of its pictures would be named {}",
                                                request.asset, output));
                if (output_owners_.contains(output)) return false;
            }
        for (const std::string& output : outputs) output_owners_.emplace(output, request.asset);
        placed_.insert(request.asset);
        tasks_[i] = std::move(tasks);
        return true;
    }

    void place_elsewhere(size_t i) {
        const AssetRequest& request = requests_[i];
        const std::string pattern = template_of(request.spec);
        if (!has_field(pattern, "asset") && !has_field(pattern, "stem"))
            refuse_template(request.spec, fmt::format("{} and another asset", request.asset),
                            "{asset}");
        const bool is_newcomer = !placed_.contains(request.asset);
        if (is_newcomer && place(i, names_[i] + fs::path(request.asset).extension().string()))
            return;
        size_t& number = numbers_.try_emplace(fs::path(names_[i]).filename(), 1).first->second;
        while (!place(i, fmt::format("{}_{}", names_[i], ++number))) continue;
    }

    const std::vector<AssetRequest>& requests_;
    const KnownNames& known_;
    std::vector<std::string> names_;  // of the requests' assets, to be tried first
    std::vector<std::vector<Task>> tasks_;
    std::map<std::string, std::string> name_owners_;    // assets, by their names in `known_`
    std::map<std::string, std::string> output_owners_;  // assets, by outputs
    std::map<std::string, size_t> numbers_;             // the last that was tried for a stem
    std::set<std::string> placed_;                      // assets that have tasks
};

}  // namespace

View camera_view(const std::string& camera) { return {camera, {{"camera", camera}}}; }

std::vector<View> make_views(std::span<const std::string> list) {
    std::vector<View> views;
    for (const std::string& element : list)
        for (const NamedView& view : expand_view(element))
            views.push_back({view.name, {{"camera", view.camera}}});
    return views;
}

void override_setting(Settings& settings, const std::string& name, const std::string& value) {
    if (name == "error") settings.erase("samples");
    if (name == "samples") settings.erase("error");
    if (name == "light") settings.erase("env");
    if (name == "env") settings.erase("light");
    settings[name] = value;
}

std::string absolute_environment(const std::string& env, const std::string& folder) {
    if (!is_environment_file(env)) return env;
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

bool makes_films(const RenderSpec& spec) {
    if (std::ranges::any_of(spec.formats, is_movie_format)) return true;
    // WebP alone: pictures, unless all frames have one name, as in `render`.
    return (spec.turntable.count || spec.frames) && !spec.name.empty() &&
           !has_field(spec.name, "frame") && std::ranges::all_of(spec.formats, can_be_movie_format);
}

std::string default_template(const RenderSpec& spec) {
    std::string pattern = "{asset}";
    if (!spec.views.empty() || spec.all_cameras) pattern += "_{view}";
    if ((spec.turntable.count || spec.frames) && !makes_films(spec)) pattern += "_{frame:04}";
    return pattern;
}

std::vector<PictureRequest> pictures_of(const RenderSpec& spec, size_t cameras) {
    std::vector<View> views = spec.views;
    for (size_t i = 0; spec.all_cameras && i < cameras; ++i) {
        views.push_back(camera_view(std::to_string(i)));
        views.back().name = fmt::format("camera{}", i);
    }
    if (views.empty()) views.push_back(spec.all_cameras ? camera_view("fit") : View());
    std::vector<PictureRequest> pictures;
    for (const View& view : views) add_pictures(spec, view, pictures);
    return pictures;
}

NameFields name_fields(const std::string& asset, const std::string& name,
                       const PictureRequest& picture) {
    const std::string extension = fs::path(asset).extension();
    NameFields fields{name, extension.empty() ? "" : extension.substr(1), picture.view, "",
                      picture.frame};
    if (const auto variant = picture.settings.find("variant"); variant != picture.settings.end())
        fields.variant = variant->second;
    return fields;
}

void check_names(const RenderSpec& spec) {
    check_films(spec);
    output_name(fill_in(template_of(spec), example_fields), "png");
    check_template(spec);
}

void check_template(const RenderSpec& spec) {
    const std::string pattern = template_of(spec);
    fill_in(pattern, example_fields);
    const auto has = [&](const char* option) { return spec.settings.contains(option); };
    if (spec.turntable.start && (!spec.views.empty() || spec.all_cameras || has("camera") ||
                                 has("look-from") || has("look-at")))
        throw NameError(
            "a turntable N@ELEVATION has its own view; with another, give the number of its "
            "pictures alone, as in --turntable 36");
    if ((spec.turntable.count || spec.frames) && !makes_films(spec) && !has_field(pattern, "frame"))
        refuse_template(spec, "all frames of an asset", "{frame:04}");
    if (spec.views.size() + 2 * spec.all_cameras < 2) return;
    if (!has_field(pattern, "view")) refuse_template(spec, "all views of an asset", "{view}");
    std::map<std::string, std::string> views;
    for (const View& view : spec.views) {
        std::string text = fill_in("{view}", {"", "", view.name, "", 0});
        const auto [other, is_new] = views.emplace(std::move(text), view.name);
        if (!is_new && other->second == view.name)
            throw NameError(fmt::format("the view '{}' is given twice", view.name));
        if (!is_new)
            throw NameError(fmt::format("the views '{}' and '{}' would have the same name",
                                        other->second, view.name));
    }
}

std::vector<Task> make_tasks(const std::vector<AssetRequest>& requests, const KnownNames& known) {
    for (const AssetRequest& request : requests)
        if (request.spec.turntable.count && request.spec.frames)
            throw Error(request.asset + ": turntable and frames exclude each other");
    return Planner(requests, known).plan();
}

std::vector<std::string> remove_repeated(std::vector<AssetRequest>& requests) {
    std::vector<std::string> repeated;
    std::map<std::string, std::vector<size_t>> kept;  // by asset
    size_t end = 0;
    for (size_t i = 0; i < requests.size(); ++i) {
        std::vector<size_t>& earlier = kept[requests[i].asset];
        if (std::ranges::any_of(earlier,
                                [&](size_t k) { return requests[k].spec == requests[i].spec; })) {
            repeated.push_back(requests[i].asset);
            continue;
        }
        earlier.push_back(end);
        if (end != i) requests[end] = std::move(requests[i]);
        ++end;
    }
    requests.resize(end);
    return repeated;
}

}  // namespace sightline
