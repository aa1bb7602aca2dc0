#pragma once
#include "batch/batch.h"

namespace sightline {

/// Throws NameError if the tasks ask for a camera that none of their assets has, all of which can
/// be read. If only some assets lack it, that is an error of those.
void check_cameras(const std::vector<PlannedTask>& tasks, const BatchRun& run);

}  // namespace sightline
