#pragma once
#include "batch/plan.h"

namespace sightline {

/// The assets that `input` names: a file, a folder searched recursively, or a pattern with * ? [ ].
/// Sorted by name. Throws Error if there is none.
std::vector<AssetRequest> find_assets(const std::string& input, const RenderSpec& spec);

}  // namespace sightline
