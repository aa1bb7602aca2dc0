#pragma once
// From what the command line names to the assets that it means.
#include "batch/journal.h"
#include "batch/plan.h"

namespace sightline {

/// How inputs are searched, and what the search has passed over.
struct InputSearch {
    bool follow_links = false;  ///< follow links that lead out of the folder that is searched
    std::vector<PassedOver> passed_over;
};

/// The assets that `input` names: a file, a folder searched recursively, or a pattern with * ? [ ].
/// Sorted by name. Folders that cannot be read, links that lead nowhere or out of the folder, and
/// files of other 3D formats are added to what `search` has passed over. Throws Error if there is
/// no asset.
std::vector<AssetRequest> find_assets(const std::string& input, const RenderSpec& spec,
                                      InputSearch& search);

}  // namespace sightline
