#pragma once
#include "scene/gltf/images.h"
#include "scene/gltf/load_options.h"
#include "scene/scene.h"

namespace sightline {

/// A scene and its images, which are still encoded.
struct GltfAsset {
    Scene scene;
    std::unique_ptr<GltfImages> images;
    double open_seconds = 0;  ///< of reading the file itself
};

/// The path that stands for standard input, and what it is called in messages and results.
inline constexpr const char* standard_input = "-";
inline constexpr const char* standard_input_name = "standard input";

/// What messages call the asset at the path.
std::string asset_label(const std::string& path);

/// Reads a .gltf or .glb file (recognised by content), posed at `options.time`, but decodes no
/// image. Standard input is read once and kept; it may refer to no files. Throws Error with file,
/// JSON path and reason if the file violates the specification in a way that affects rendering;
/// other deviations become lines of Scene::warnings.
GltfAsset read_gltf(const std::string& path, const LoadOptions& options = {});

/// The same with all images as they are in their files.
Scene load_gltf(const std::string& path, const LoadOptions& options = {});

}  // namespace sightline
