#pragma once
// The subcommands: each adds itself to `app` and runs if it was chosen.
#include "help.h"

namespace sightline {

/// `command_line` is for the pictures' metadata.
void add_render_command(CLI::App& app, const std::string& command_line);
void add_faults_command(CLI::App& app);
void add_info_command(CLI::App& app);
void add_diff_command(CLI::App& app);
void add_compare_command(CLI::App& app, const std::string& command_line);
void add_batch_command(CLI::App& app);
void add_worker_command(CLI::App& app);
void add_farm_commands(CLI::App& app);
void add_atlas_command(CLI::App& app);
/// To be added last: it describes the others.
void add_manual_command(CLI::App& app);

}  // namespace sightline
