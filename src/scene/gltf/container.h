#pragma once
// The .gltf and .glb containers and their JSON. Internal to src/scene.
#include "scene/gltf/faults.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// The contents of a .gltf or .glb file; both views point into the file's bytes.
struct GltfContainer {
    std::string_view json;
    std::optional<std::span<const std::byte>> bin;  ///< a GLB's binary chunk
    /// A fault with its place and detail; the same may occur several times.
    struct ContainerFault {
        Fault fault;
        std::string place, detail;
    };
    std::vector<ContainerFault> faults;
};

/// Splits a file, whose format is recognised by content. Throws Error with `path` if a GLB is
/// damaged.
GltfContainer split_container(std::span<const std::byte> file, const std::string& path);

/// Parses a glTF file's JSON text. Throws Error with `path` if it is empty, malformed, larger than
/// 1 GiB, or nested so deeply that a recursive parser could overflow the stack.
nlohmann::json parse_json(std::string_view text, const std::string& path);

}  // namespace sightline
