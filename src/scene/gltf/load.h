#pragma once
#include "scene/gltf/load_options.h"
#include "scene/scene.h"

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace sightline {

struct Document;
class GltfImages;
class ScenePoser;

/// A glTF file in memory, from which its scene gets images and, if it has animations, poses.
class GltfFile {
  public:
    enum class Times { one, any };

    /// Fills `scene` at the options' time. With Times::one, or without a time, what only poses need
    /// is freed. Throws Error.
    GltfFile(std::unique_ptr<Document> document, const LoadOptions& options, Times times,
             Scene& scene);
    ~GltfFile();

    /// Width and height of each image; see GltfImages::sizes.
    std::vector<std::array<int, 2>> image_sizes() const;

    /// Fills Scene::images at the levels `wanted`; see GltfImages::decode.
    void decode_images(std::span<const WantedLevel> wanted, Scene& scene);

    /// What a pose has changed, beside cameras and lights.
    struct Change {
        bool geometry = false;  ///< vertices, shapes or instances
        bool textures = false;  ///< materials, textures and images, which are to be decoded
    };

    /// Takes the scene to another time, in seconds. It is as if the file were read at that time;
    /// what does not change stays where it is. Not with Times::one, nor without a time before.
    /// Throws Error, which leaves a scene that cannot be used.
    Change pose(float time, Scene& scene);

  private:
    LoadOptions options_;
    std::unique_ptr<Document> document_;
    std::unique_ptr<ScenePoser> poser_;
    std::unique_ptr<GltfImages> images_;
};

/// A scene and the file that it was read from, whose images are still encoded.
struct GltfAsset {
    Scene scene;
    std::unique_ptr<GltfFile> file;
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
GltfAsset read_gltf(const std::string& path, const LoadOptions& options = {},
                    GltfFile::Times times = GltfFile::Times::one);

/// The same with all images as they are in their files.
Scene load_gltf(const std::string& path, const LoadOptions& options = {});

}  // namespace sightline
