#pragma once
// The options of `render`, one function per concern, for every subcommand that uses them.
#include "help.h"
#include "output/options.h"

#include <fmt/format.h>

#include <limits>

namespace sightline {

/// The parts of the file to load, and limits except that of images: group Input.
void add_load_options(CLI::App& app, LoadOptions& load);

/// The camera's position and target: part of the group View.
void add_camera_options(CLI::App& app, ViewOptions& view);
void add_aperture_option(CLI::App& app, RenderSettings& settings);

/// Throws CLI::ValidationError if the camera's position, target and up vector make no view.
void check_view(const ViewOptions& view);

/// The environment: part of the group Light.
void add_environment_option(CLI::App& app, LightOptions& light);

/// Integrator and depth: part of the group Quality.
void add_transport_options(CLI::App& app, RenderSettings& settings);

/// Everything that decides which rays are traced: the groups Input, View, Light and Quality.
void add_ray_options(CLI::App& app, RenderCommand& command);

/// How display pictures look: part of the group Output.
void add_display_options(CLI::App& app, OutputOptions& output);

/// Layers and EXR files: group Layers.
void add_layer_options(CLI::App& app, RenderCommand& command);

/// Engine and threads: group Performance.
void add_performance_options(CLI::App& app, RenderCommand& command);

/// The argument SCENE.
void add_scene_argument(CLI::App& app, std::string& path);

/// Accepts these words only.
CLI::Validator one_of(const std::vector<std::string>& words);

/// An option whose text `store` reads; std::invalid_argument from it is a usage error.
CLI::Option* add_parsed(CLI::App& app, const std::string& name, const std::string& value,
                        const std::string& text,
                        const std::function<void(const std::string&)>& store);

/// A repeatable option of the form NAME=PATH.
CLI::Option* add_named_paths(CLI::App& app, const std::string& name, const std::string& form,
                             const std::string& text,
                             std::vector<std::pair<std::string, std::string>>& to);

/// An option whose value is one of `choices`; --help shows the present one as the default.
template <class T>
CLI::Option* add_choice(CLI::App& app, const std::string& name, T& to, const std::string& text,
                        const std::vector<std::pair<std::string, T>>& choices) {
    std::vector<std::string> words;
    std::string present;
    for (const auto& [word, value] : choices) {
        words.push_back(word);
        if (value == to) present = word;
    }
    const auto store = [&to, choices](const std::string& chosen) {
        for (const auto& [word, value] : choices)
            if (word == chosen) to = value;
    };
    return app.add_option_function<std::string>(name, store, text)
        ->type_name("NAME")
        ->check(one_of(words))
        ->default_str(present);
}

/// The number as in help and messages: 0.000001, not 1e-06.
template <class T>
std::string number_text(T number) {
    std::string text = fmt::format("{}", number);
    if constexpr (std::is_floating_point_v<T>)
        if (text.find("e-") != std::string::npos && number >= T(1e-9)) {
            text = fmt::format("{:.9f}", number);
            text.erase(text.find_last_not_of('0') + 1);
        }
    return text;
}

/// If `text` is a whole number with an exponent, such as 1e3, writes it without: CLI11 reads whole
/// numbers in digits only.
void expand_exponent(std::string& text);

/// Accepts numbers of type T in [low, high]; neither bound may be infinite, so that no infinity is
/// accepted.
template <class T>
CLI::Validator number_between(T low, T high) {
    const auto check = [=](std::string& text) -> std::string {
        T value{};
        std::string digits = text;
        if constexpr (std::is_integral_v<T>) expand_exponent(digits);
        if (CLI::detail::lexical_cast(digits, value) && value >= low && value <= high) {
            text = digits;
            return {};
        }
        const char* kind = std::is_integral_v<T> ? "whole" : "finite";
        constexpr T lowest = std::numeric_limits<T>::lowest(), most = std::numeric_limits<T>::max();
        if (high != most)
            return fmt::format("'{}' is not a {}number from {} to {}", text,
                               std::is_integral_v<T> ? "whole " : "", number_text(low),
                               number_text(high));
        if (low != lowest || std::is_unsigned_v<T>)
            return fmt::format("'{}' is not a {} number from {}", text, kind, number_text(low));
        return fmt::format("'{}' is not a {} number", text, kind);
    };
    return {check, ""};
}

/// Accepts finite numbers above 0.
CLI::Validator positive_number();

/// A number in [low, high], stored in `to`, a T or an optional T. --help shows the bounds, unless
/// there is no upper one, and the present value as the default.
template <class T, class To>
CLI::Option* add_number(CLI::App& app, const std::string& name, To& to, const std::string& value,
                        std::string text, T low, T high = std::numeric_limits<T>::max()) {
    if (high != std::numeric_limits<T>::max())
        text += fmt::format(", {} to {}", number_text(low), number_text(high));
    CLI::Option* option =
        app.add_option(name, to, text)->type_name(value)->transform(number_between<T>(low, high));
    if constexpr (std::is_same_v<T, To>) option->default_str(fmt::format("{}", to));
    return option;
}

/// The option --overwrite of a command that writes a report.
void add_overwrite_option(CLI::App& app, bool& overwrite);

}  // namespace sightline
