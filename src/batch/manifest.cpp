// The manifest: render's options under their own names, and what a batch adds to them.
#include "batch/plan.h"
#include "core/error.h"
#include "core/files.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <filesystem>

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class Reader {
  public:
    Reader(const std::string& path, const std::set<std::string>& options)
        : path_(path), options_(options) {}

    std::vector<Order> read(const PictureSet& defaults) const {
        const auto bytes = read_file(path_, uint64_t{1} << 30);
        const auto* text = reinterpret_cast<const char*>(bytes.data());
        json manifest;
        try {
            manifest = json::parse(text, text + bytes.size());
        } catch (const json::parse_error& e) {
            fail("", fmt::format("is no JSON at byte {}", e.byte));
        }
        if (!manifest.is_object()) fail("", "is not an object");
        PictureSet shared = defaults;
        std::vector<Order> orders;
        apply(manifest, "", {"assets", "$schema"}, shared);
        if (!manifest.contains("assets") || !manifest["assets"].is_array())
            fail("assets", "is missing, or no array");
        for (size_t i = 0; i < manifest["assets"].size(); ++i)
            add(manifest["assets"][i], fmt::format("assets[{}]", i), shared, orders);
        return orders;
    }

  private:
    [[noreturn]] void fail(const std::string& place, const std::string& what) const {
        throw Error(fmt::format("{}: {}{}{}", path_, place, place.empty() ? "" : ": ", what));
    }

    void add(const json& entry, const std::string& place, PictureSet pictures,
             std::vector<Order>& orders) const {
        if (!entry.is_object()) fail(place, "is not an object");
        apply(entry, place, {"path"}, pictures);
        if (!entry.contains("path") || !entry["path"].is_string())
            fail(place + ".path", "is missing, or no text");
        const fs::path input = fs::path(path_).parent_path() / entry["path"].get<std::string>();
        try {
            for (Order& order : find_assets(input.string(), pictures))
                orders.push_back(std::move(order));
        } catch (const Error& e) {
            fail(place + ".path", e.what());
        }
    }

    // Takes over all members of `object` but those in `others`.
    void apply(const json& object, const std::string& place, const std::set<std::string>& others,
               PictureSet& pictures) const {
        double fps = pictures.frames ? pictures.frames->fps : 24;
        if (object.contains("fps")) fps = number(object["fps"], place + ".fps");
        if (pictures.frames) pictures.frames->fps = fps;
        for (const auto& [name, value] : object.items()) {
            const std::string at = place.empty() ? name : place + "." + name;
            if (others.contains(name) || name == "fps") continue;
            if (name == "views") {
                pictures.views = views(value, at);
            } else if (name == "all-cameras") {
                pictures.all_cameras = value == true;
            } else if (name == "turntable") {
                pictures.turntable = static_cast<int>(number(value, at));
                if (pictures.turntable < 0 || pictures.turntable > 100'000)
                    fail(at, "is not between 0 and 100000");
            } else if (name == "frames") {
                pictures.frames = frames(value, at, fps);
            } else if (name == "name") {
                pictures.name = text(value, at);
            } else if (name == "format") {
                pictures.formats = texts(value, at);
            } else {
                set(pictures.settings, name, value, at);
            }
        }
    }

    void set(Settings& settings, const std::string& name, const json& value,
             const std::string& place) const {
        if (!options_.contains(name)) fail(place, "is no option of render or batch");
        if (value == false || value.is_null()) {
            settings.erase(name);
        } else {
            std::string setting = text(value, place);
            if (name == "env") setting = absolute_environment(setting, folder());
            override_setting(settings, name, setting);
        }
    }

    std::string folder() const { return fs::absolute(path_).parent_path().string(); }

    std::vector<View> views(const json& value, const std::string& place) const {
        std::vector<View> result;
        if (value.is_array()) {
            for (const std::string& name : texts(value, place))
                result.push_back(view_of_camera(name));
            return result;
        }
        if (!value.is_object()) fail(place, "is neither a list of names nor an object of views");
        for (const auto& [name, settings] : value.items()) {
            const std::string at = place + "." + name;
            if (!settings.is_object()) fail(at, "is not an object");
            View& view = result.emplace_back();
            view.name = name;
            for (const auto& [option, setting] : settings.items())
                set(view.settings, option, setting, at + "." + option);
        }
        return result;
    }

    FrameRange frames(const json& value, const std::string& place, double fps) const {
        try {
            return parse_frames(text(value, place), fps);
        } catch (const Error& e) {
            fail(place, e.what());
        }
    }

    double number(const json& value, const std::string& place) const {
        if (!value.is_number()) fail(place, "is no number");
        return value.get<double>();
    }

    // As the command line would write it.
    std::string text(const json& value, const std::string& place) const {
        if (value.is_string()) return value.get<std::string>();
        if (value.is_number()) return value.dump();
        if (value == true) return "";
        if (!value.is_array() || value.empty()) fail(place, "is neither text, number nor a list");
        std::string joined;
        for (const std::string& part : texts(value, place))
            joined += (joined.empty() ? "" : ",") + part;
        return joined;
    }

    std::vector<std::string> texts(const json& value, const std::string& place) const {
        if (value.is_string()) return {value.get<std::string>()};
        if (!value.is_array() || value.empty()) fail(place, "is no list of texts");
        std::vector<std::string> result;
        for (const json& part : value) {
            if (part.is_structured()) fail(place, "holds more than texts and numbers");
            result.push_back(text(part, place));
        }
        return result;
    }

    std::string path_;
    const std::set<std::string>& options_;
};

}  // namespace

std::vector<Order> read_manifest(const std::string& path, const PictureSet& defaults,
                                 const std::set<std::string>& options) {
    return Reader(path, options).read(defaults);
}

}  // namespace sightline
