#pragma once
// The options of pictures, as the settings of each, for the commands that make several.
#include "batch/task.h"
#include "options.h"
#include "scene/view_names.h"

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sightline {

/// All options of `render` that may change a picture, and --threads.
void add_picture_options(CLI::App& app, RenderCommand& command);

/// Those of the command's options that add_picture_options adds, without --threads.
std::vector<const CLI::Option*> setting_options(const CLI::App& app);

/// The names of the options, without dashes.
std::set<std::string> names_of(const std::vector<const CLI::Option*>& options);

/// The options that the command line gives, with their values.
Settings given_settings(const std::vector<const CLI::Option*>& options);

/// The command that renders the asset with these settings, without outputs. Throws Error.
RenderCommand parse_settings(const std::string& asset, const Settings& settings);

/// --views: elements for make_views.
CLI::Option* add_views_option(CLI::App& app, std::vector<std::string>& views);

/// --turntable.
CLI::Option* add_turntable_option(CLI::App& app, Ring& turntable);

/// Frames of an animation, and how many there are in a second, of films of turntables, too.
struct FrameOptions {
    std::string range;  ///< FIRST..LAST; empty: no frames
    double fps = 24;

    /// The frames that are asked for, if any.
    std::optional<FrameRange> frames() const;
};

/// --frames, which is returned, and --fps. --turntable must have been added.
CLI::Option* add_frames_options(CLI::App& app, FrameOptions& options);

}  // namespace sightline
