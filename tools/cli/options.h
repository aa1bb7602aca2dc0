#pragma once
#include "output/asset.h"

#include <CLI/CLI.hpp>

namespace sightline {

/// Adds the options that choose what is loaded and seen (render, info, compare, batch).
void add_scene_options(CLI::App& app, AssetOptions& options);

/// Adds the options that describe a picture.
void add_picture_options(CLI::App& app, AssetOptions& options);

/// The subcommands: each adds itself to `app` and runs when it was chosen.
/// `command` is the whole command line, for the pictures' metadata.
void add_render_command(CLI::App& app, const std::string& command);
void add_info_command(CLI::App& app);
void add_diff_command(CLI::App& app);
void add_compare_command(CLI::App& app, const std::string& command);
void add_batch_command(CLI::App& app);
void add_worker_command(CLI::App& app);
void add_farm_commands(CLI::App& app);
void add_atlas_command(CLI::App& app);
/// To be added last: it tells of the others.
void add_manual_command(CLI::App& app);

}  // namespace sightline
