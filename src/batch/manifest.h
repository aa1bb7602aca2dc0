#pragma once
#include "batch/inputs.h"

#include <set>

namespace sightline {

/// Reads a manifest (docs/batch-manifest.schema.json), whose entries override `defaults`.
/// `options`: names of render's options; `search`: see find_assets. Throws Error with the JSON
/// path.
std::vector<AssetRequest> read_manifest(const std::string& path, const RenderSpec& defaults,
                                        const std::set<std::string>& options, InputSearch& search);

}  // namespace sightline
