#pragma once
#include "scene/gltf/load_options.h"
#include "scene/scene.h"

#include <memory>
#include <span>

namespace sightline {

struct Document;
struct ImageWork;

/// The encoded images of a file, from which those of its scene are decoded at the levels that
/// pictures need.
class GltfImages {
  public:
    /// Reads the images that the materials in use refer to. Of those with equal content, textures
    /// then refer to the first. Reports images that are missing, or that are KTX2, and removes the
    /// references to them from the materials, unless a checker takes their place.
    GltfImages(std::unique_ptr<Document> document, const LoadOptions& options, Scene& scene);
    ~GltfImages();

    /// By image: width and height, by the header; zeros for those of floats, those that are not
    /// used and those whose header does not tell.
    std::vector<std::array<int, 2>> sizes() const;

    /// Fills Scene::images at the levels `wanted`, by image, in parallel; empty: at level 0. What
    /// has been decoded at its level stays. Reports damaged images as the constructor does lost
    /// ones. Throws LimitError if an image or all of them together are too large.
    void decode(std::span<const WantedLevel> wanted, Scene& scene);

  private:
    void replace_lost(Scene& scene);

    std::unique_ptr<Document> document_;
    LoadOptions options_;
    std::unique_ptr<ImageWork> work_;
};

/// Decodes all images of the file, and reports those that are missing or damaged, or that are KTX2.
/// Throws LimitError as GltfImages::decode does.
void check_images(Document& document, const LoadOptions& options);

}  // namespace sightline
