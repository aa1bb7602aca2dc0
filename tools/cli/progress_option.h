#pragma once
#include "help.h"

namespace sightline {

/// The option --progress, which takes effect as it is read.
void add_progress_option(CLI::App& app);

}  // namespace sightline
