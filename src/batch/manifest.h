#pragma once
#include "batch/plan.h"

#include <set>

namespace sightline {

/// Reads a manifest (docs/batch-manifest.schema.json), whose entries override `defaults`.
/// `options`: names of render's options. Throws Error with the JSON path.
std::vector<AssetRequest> read_manifest(const std::string& path, const RenderSpec& defaults,
                                        const std::set<std::string>& options);

}  // namespace sightline
