#pragma once
#include "scene/scene.h"

#include <optional>

namespace sightline {

/// What of a file to load, and how much a file may ask for.
struct LoadOptions {
    std::string scene;           ///< name or index; empty: the file's default, or its first
    std::string variant;         ///< of KHR_materials_variants, name or index; empty: none
    std::string animation;       ///< name, index or "all"; empty: "all" where `time` is given
    std::optional<float> time;   ///< seconds; unset: the rest pose, or 0 of the `animation`
    bool allow_outside = false;  ///< let URIs leave the file's folder
    bool decode_images = true;   ///< false: images stay empty (for `info`)
    ImageLimits images;
    uint64_t max_elements = 1ull << 29;  ///< largest accessor count
    uint64_t max_values = 1ull << 32;    ///< numbers read from all accessors together
    uint64_t max_file_bytes = 1ull << 33;
};

/// Loads a .gltf or .glb (recognised by content) as world-ready data, posed at `time`.
/// Throws Error with file, JSON path and reason on what the specification forbids and rendering
/// depends on; everything else becomes a line in Scene::warnings.
Scene load_gltf(const std::string& path, const LoadOptions& options = {});

}  // namespace sightline
