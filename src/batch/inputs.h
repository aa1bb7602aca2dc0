#pragma once
// From what the command line names to the assets that it means.
#include "batch/journal.h"
#include "batch/plan.h"

namespace sightline {

/// How inputs are searched, and what the search has passed over.
struct InputSearch {
    bool follow_links = false;  ///< follow links that lead out of the folder that is searched
    std::vector<PassedOver> passed_over;
    std::string problem;  ///< one line: why the first input that names no asset names none
};

/// The assets that `input` names: a file, a folder searched recursively, or a pattern with * ? [ ].
/// Sorted by name. Folders that cannot be read, links that lead nowhere or out of the folder, files
/// of other 3D formats, and folders and patterns without assets are added to what `search` has
/// passed over. A file that does not exist is an asset, which fails when it is rendered.
std::vector<AssetRequest> find_assets(const std::string& input, const RenderSpec& spec,
                                      InputSearch& search);

/// Throws Error with the search's problem if none of the assets exists.
void check_that_one_exists(const std::vector<AssetRequest>& requests, const InputSearch& search);

}  // namespace sightline
