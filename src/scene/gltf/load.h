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

/// Reads a .gltf or .glb file (recognised by content), posed at `options.time`, but decodes no
/// image. Throws Error with file, JSON path and reason if the file violates the specification in a
/// way that affects rendering; other deviations become lines of Scene::warnings.
GltfAsset read_gltf(const std::string& path, const LoadOptions& options = {});

/// The same with all images as they are in their files.
Scene load_gltf(const std::string& path, const LoadOptions& options = {});

}  // namespace sightline
