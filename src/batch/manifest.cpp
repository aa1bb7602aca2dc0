#include "batch/manifest.h"

#include "core/error.h"
#include "core/files.h"
#include "core/suggest.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <iterator>

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Reads the members of a manifest by name; each check reports the JSON path of the member.
class ManifestReader {
  public:
    ManifestReader(const std::string& file, const std::set<std::string>& options,
                   InputSearch& search)
        : file_(file), options_(options), search_(search) {}

    std::vector<AssetRequest> read(const RenderSpec& defaults) const {
        const auto bytes = read_file(file_, uint64_t{1} << 30);
        const auto* text = reinterpret_cast<const char*>(bytes.data());
        json manifest;
        try {
            manifest = json::parse(text, text + bytes.size());
        } catch (const json::parse_error& e) {
            fail("", fmt::format("invalid JSON at byte {}", e.byte));
        }
        if (!manifest.is_object()) fail("", "must be an object");
        RenderSpec shared = defaults;
        std::vector<AssetRequest> requests;
        apply(manifest, "", {"assets", "$schema"}, shared);
        if (!manifest.contains("assets") || !manifest["assets"].is_array())
            fail("assets", "is missing or not an array");
        for (size_t i = 0; i < manifest["assets"].size(); ++i)
            add(manifest["assets"][i], fmt::format("assets[{}]", i), shared, requests);
        return requests;
    }

  private:
    [[noreturn]] void fail(const std::string& path, const std::string& what) const {
        throw Error(fmt::format("{}: {}{}{}", file_, path, path.empty() ? "" : ": ", what));
    }

    void add(const json& entry, const std::string& path, RenderSpec spec,
             std::vector<AssetRequest>& requests) const {
        if (!entry.is_object()) fail(path, "must be an object");
        apply(entry, path, {"path"}, spec);
        if (!entry.contains("path") || !entry["path"].is_string())
            fail(path + ".path", "is missing or not a string");
        const fs::path input = fs::path(file_).parent_path() / entry["path"].get<std::string>();
        try {
            check_names(spec);
            const bool had_problem = !search_.problem.empty();
            std::ranges::move(find_assets(input.string(), spec, search_),
                              std::back_inserter(requests));
            if (!had_problem && !search_.problem.empty())
                search_.problem = fmt::format("{}: {}.path: {}", file_, path, search_.problem);
        } catch (const NameError& e) {
            fail(path, e.what());
        } catch (const Error& e) {
            fail(path + ".path", e.what());
        }
    }

    // Applies all members of `object` except those named in `others`.
    void apply(const json& object, const std::string& path, const std::set<std::string>& others,
               RenderSpec& spec) const {
        double fps = spec.frames ? spec.frames->fps : spec.fps;
        if (object.contains("fps")) fps = number(object["fps"], path + ".fps");
        if (spec.frames) spec.frames->fps = fps;
        spec.fps = fps;
        for (const auto& [name, value] : object.items()) {
            const std::string member = path.empty() ? name : path + "." + name;
            if (others.contains(name) || name == "fps") continue;
            if (name == "views") {
                spec.views = views(value, member);
            } else if (name == "all-cameras") {
                spec.all_cameras = value == true;
            } else if (name == "use-file-cameras") {
                spec.use_file_cameras = value == true;
            } else if (name == "turntable") {
                spec.turntable = turntable(value, member);
            } else if (name == "frames") {
                spec.frames = frames(value, member, fps);
            } else if (name == "name") {
                spec.name = text(value, member);
            } else if (name == "format") {
                spec.formats = texts(value, member);
            } else {
                set(spec.settings, name, value, member);
            }
        }
    }

    void set(Settings& settings, const std::string& name, const json& value,
             const std::string& path) const {
        if (!options_.contains(name)) {
            const std::vector<std::string> words(options_.begin(), options_.end());
            fail(path, "is not an option of render or batch" + did_you_mean(name, words));
        }
        if (value == false || value.is_null()) {
            settings.erase(name);
        } else {
            std::string setting = text(value, path);
            if (name == "env") setting = absolute_environment(setting, folder());
            override_setting(settings, name, setting);
        }
    }

    std::string folder() const { return fs::absolute(file_).parent_path().string(); }

    // What `function` returns; an Error gets the path.
    template <class Function>
    auto parse(const std::string& path, const Function& function) const {
        try {
            return function();
        } catch (const Error& e) {
            fail(path, e.what());
        }
    }

    std::vector<View> views(const json& value, const std::string& path) const {
        std::vector<View> result;
        if (value.is_array()) {
            const std::vector<std::string> list = texts(value, path);
            return parse(path, [&] { return make_views(list); });
        }
        if (!value.is_object()) fail(path, "must be a list of names or an object of views");
        for (const auto& [name, settings] : value.items()) {
            const std::string member = path + "." + name;
            if (!settings.is_object()) fail(member, "must be an object");
            View& view = result.emplace_back();
            view.name = name;
            for (const auto& [option, setting] : settings.items())
                set(view.settings, option, setting, member + "." + option);
        }
        return result;
    }

    Ring turntable(const json& value, const std::string& path) const {
        if (value == 0) return {};
        const std::string given = text(value, path);
        return parse(path, [&] { return parse_ring(given); });
    }

    FrameRange frames(const json& value, const std::string& path, double fps) const {
        const std::string range = text(value, path);
        return parse(path, [&] { return parse_frames(range, fps); });
    }

    double number(const json& value, const std::string& path) const {
        if (!value.is_number()) fail(path, "must be a number");
        return value.get<double>();
    }

    // The value as written on the command line; "" for a flag.
    std::string text(const json& value, const std::string& path) const {
        if (value.is_string()) return value.get<std::string>();
        if (value.is_number()) return value.dump();
        if (value == true) return "";
        if (!value.is_array() || value.empty()) fail(path, "must be a string, a number or a list");
        std::string joined;
        for (const std::string& part : texts(value, path))
            joined += (joined.empty() ? "" : ",") + part;
        return joined;
    }

    std::vector<std::string> texts(const json& value, const std::string& path) const {
        if (value.is_string()) return {value.get<std::string>()};
        if (!value.is_array() || value.empty()) fail(path, "must be a list of strings");
        std::vector<std::string> result;
        for (const json& part : value) {
            if (part.is_structured()) fail(path, "may hold strings and numbers only");
            result.push_back(text(part, path));
        }
        return result;
    }

    std::string file_;
    const std::set<std::string>& options_;
    InputSearch& search_;
};

}  // namespace

std::vector<AssetRequest> read_manifest(const std::string& path, const RenderSpec& defaults,
                                        const std::set<std::string>& options, InputSearch& search) {
    return ManifestReader(path, options, search).read(defaults);
}

}  // namespace sightline
