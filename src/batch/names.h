#pragma once
// What pictures are called: the template of their names, and how assets of one name are told apart.
#include "core/error.h"

#include <map>
#include <string>
#include <vector>

namespace sightline {

/// The names that were asked for cannot be given: the command line or the manifest is at fault.
struct NameError : Error {
    using Error::Error;
};

/// Values of the fields of a name template.
struct NameFields {
    std::string asset;  ///< {asset}; its last component is {stem}
    std::string extension, view, variant;
    int frame = 0;
};

/// The template with its fields filled in. Throws NameError if it is malformed.
std::string fill_in(const std::string& name_template, const NameFields& fields);

/// Whether the template has a field of this name, such as "frame" in "{stem}_{frame:04}".
bool has_field(const std::string& name_template, const std::string& field);

/// The template with one more field, such as "{frame:04}", which takes the place of a "%04d", else
/// stands at the end, before an ending such as ".png".
std::string with_field(const std::string& name_template, const std::string& field);

/// The name, with components shortened that would be longer than file names may be once `format`
/// is appended; a hash of the whole component keeps the names of different pictures different.
/// Throws NameError if the name is not that of a file below the batch's folder.
std::string output_name(const std::string& name, const std::string& format);

/// The names that assets have had in a batch, by the asset's path.
using KnownNames = std::map<std::string, std::vector<std::string>>;

/// An asset and the name that it would have if it were the only one.
struct NamedAsset {
    std::string asset;  ///< absolute path
    std::string name;   ///< path below the folder that was searched, no extension
};

/// For each asset its name or, if assets of the same name lie in other folders, as much of its path
/// as tells the folders apart.
std::vector<std::string> mirrored_names(const std::vector<NamedAsset>& assets,
                                        const KnownNames& known);

}  // namespace sightline
