#pragma once
// From bytes to JSON text and binary chunk, and from URIs to bytes. Internal to src/scene.
#include <cstddef>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// What a .gltf or .glb holds; both views point into the file's bytes.
struct GltfContainer {
    std::string_view json;
    std::optional<std::span<const std::byte>> bin;  ///< a GLB's binary chunk
    std::set<std::string> warnings;
};

/// Splits a file, told apart by content. Throws Error with `path` on a damaged GLB.
GltfContainer split_container(std::span<const std::byte> file, const std::string& path);

/// Throws Error with `path` where brackets nest deeper than a parser's stack can be trusted with.
void check_json_depth(std::string_view json, const std::string& path);

/// "%20" → " ". Nothing where a % has no two hexadecimal digits.
std::optional<std::string> percent_decode(std::string_view text);

/// Whether a URI holds its data itself ("data:", in any case).
bool is_data_uri(std::string_view uri);

/// The bytes of a data URI's part behind the scheme; nothing where it is malformed.
std::optional<std::vector<std::byte>> decode_data_uri(std::string_view uri);

}  // namespace sightline
