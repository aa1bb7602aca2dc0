#include "picture_options.h"

#include "batch/plan.h"
#include "core/error.h"
#include "usage.h"

#include <algorithm>

namespace sightline {
namespace {

std::string long_name(const CLI::Option& option) {
    return option.get_lnames().empty() ? "" : option.get_lnames()[0];
}

// What is wrong with an element of --views; "" if nothing is.
std::string view_problem(const std::string& element) {
    try {
        expand_view(element);
        return "";
    } catch (const Error& e) {
        return e.what();
    }
}

}  // namespace

void add_picture_options(CLI::App& app, RenderCommand& command) {
    add_ray_options(app, command);
    add_display_options(app, command.output);
    add_layer_options(app, command);
    add_performance_options(app, command);
}

std::vector<const CLI::Option*> setting_options(const CLI::App& app) {
    CLI::App pictures;
    pictures.set_help_flag();
    RenderCommand unused;
    add_picture_options(pictures, unused);
    return app.get_options([&](const CLI::Option* option) {
        const std::string name = long_name(*option);
        return !name.empty() && name != "threads" && pictures.get_option_no_throw("--" + name);
    });
}

std::set<std::string> names_of(const std::vector<const CLI::Option*>& options) {
    std::set<std::string> names;
    for (const CLI::Option* option : options) names.insert(long_name(*option));
    return names;
}

Settings given_settings(const std::vector<const CLI::Option*>& options) {
    Settings settings;
    for (const CLI::Option* option : options) {
        if (option->count() == 0) continue;
        std::string& value = settings[long_name(*option)];
        if (option->get_expected_max() == 0) continue;  // a flag
        for (const std::string& part : option->results())
            value += (value.empty() ? "" : ",") + part;
    }
    return settings;
}

RenderCommand parse_settings(const std::string& asset, const Settings& settings) {
    RenderCommand command;
    CLI::App app;
    add_picture_options(app, command);
    std::vector<std::string> arguments;
    for (const auto& [name, value] : settings)
        arguments.push_back("--" + name + (value.empty() ? "" : "=" + value));
    try {
        app.parse(arguments);
    } catch (const CLI::ParseError& e) {
        throw Error(asset + ": " + plain_message(e));
    }
    command.asset = asset;
    return command;
}

CLI::Option* add_views_option(CLI::App& app, std::vector<std::string>& views) {
    return app
        .add_option("--views", views,
                    "Several views, of those that --camera takes; ring:8@20: eight all around, 20 "
                    "degrees above the horizon; sphere:12: twelve from all directions")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("VIEW,...")
        ->check(CLI::Validator(view_problem, {}));
}

CLI::Option* add_turntable_option(CLI::App& app, Ring& turntable) {
    return add_parsed(app, "--turntable", "N[@ELEVATION]",
                      "Number of views evenly spaced around the asset; 36@20: seen from 20 degrees "
                      "above the horizon; 36@45/20: the first from azimuth 45",
                      [&turntable](const std::string& text) { turntable = parse_ring(text); })
        ->default_str("none");
}

std::optional<FrameRange> FrameOptions::frames() const {
    if (range.empty()) return {};
    return parse_frames(range, fps);
}

CLI::Option* add_frames_options(CLI::App& app, FrameOptions& options) {
    CLI::Option* frames =
        add_parsed(app, "--frames", "FIRST..LAST", "Frames of the animation, such as 0..47",
                   [&options](const std::string& text) {
                       parse_frames(text, 1);
                       options.range = text;
                   });
    frames->excludes(app.get_option("--turntable"));
    app.add_option("--fps", options.fps, "Frames per second, of the animation and of films")
        ->type_name("N")
        ->capture_default_str()
        ->check(positive_number());
    return frames;
}

}  // namespace sightline
