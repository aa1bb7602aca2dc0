#pragma once
#include <set>
#include <span>
#include <string>

namespace sightline {

/// Name of the folder, within a folder of outputs, for what is not meant for readers.
inline constexpr const char* private_folder = ".sightline";

/// Makes a folder for outputs if it does not exist. Throws Error, with the advice to choose another
/// value of `option`.
void make_output_folder(const std::string& path, const std::string& option);

/// Claims files of a folder for this program before they are written. Claims are recorded in the
/// private folder, so a later run recognises the files as this program's; files of other origin
/// are never replaced. `names`: paths relative to `folder`, which must exist; `own`: names that
/// are known to be this program's from elsewhere. A claimed name that is a symbolic link is
/// removed: it is replaced, not followed.
/// Throws Error if a file exists without a claim, unless `overwrite`, and if a name or the private
/// folder leads out of `folder` through a symbolic link.
void claim_outputs(const std::string& folder, std::span<const std::string> names,
                   const std::set<std::string>& own, bool overwrite);

}  // namespace sightline
