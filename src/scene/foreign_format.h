#pragma once
#include <cstddef>
#include <span>
#include <string>

namespace sightline {

/// For a 3D file that is not glTF: its format, recognised by its first bytes or else by the path's
/// extension, and what converts it, as the rest of a sentence about the file. Empty if it is none
/// of the formats known here.
std::string describe_foreign_format(const std::string& path, std::span<const std::byte> begin);

}  // namespace sightline
