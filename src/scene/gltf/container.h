#pragma once
// The .gltf and .glb containers, and the encodings of URIs. Internal to src/scene.
#include <cstddef>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// The contents of a .gltf or .glb file; both views point into the file's bytes.
struct GltfContainer {
    std::string_view json;
    std::optional<std::span<const std::byte>> bin;  ///< a GLB's binary chunk
    std::set<std::string> warnings;
};

/// Splits a file, whose format is recognised by content. Throws Error with `path` if a GLB is
/// damaged.
GltfContainer split_container(std::span<const std::byte> file, const std::string& path);

/// Decodes "%20" to " ". Empty if a % is not followed by two hexadecimal digits.
std::optional<std::string> percent_decode(std::string_view text);

/// Whether a URI starts with "data:", in any case.
bool is_data_uri(std::string_view uri);

/// The bytes encoded in a data URI; empty if it is malformed.
std::optional<std::vector<std::byte>> decode_data_uri(std::string_view uri);

}  // namespace sightline
