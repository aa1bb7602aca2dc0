#pragma once
#include "scene/gltf/load_options.h"
#include "scene/scene.h"

#include <memory>
#include <span>
#include <vector>

namespace sightline {

struct Document;
struct ImageWork;
class ScenePoser;

/// The encoded images of a file, from which those of its scene are decoded at the levels that
/// pictures need. The document and the options must outlive it.
class GltfImages {
  public:
    GltfImages(Document& document, const LoadOptions& options);
    ~GltfImages();

    /// Reads the images that the materials in use refer to, as `poser` has them, unless they have
    /// been read. Of those with equal content, the scene's textures then refer to the first.
    /// Reports images that are missing, or that are KTX2, and removes the references to them from
    /// the scene's materials, unless a checker takes their place. Returns whether other images than
    /// before are in use: those that were decoded are empty then.
    bool choose(const ScenePoser& poser, Scene& scene);

    /// By image: width and height, by the header; zeros for those of floats, those that are not
    /// used and those whose header does not tell.
    std::vector<std::array<int, 2>> sizes() const;

    /// Fills Scene::images at the levels `wanted`, by image, in parallel; empty: at level 0. What
    /// has been decoded at its level stays. Reports damaged images as choose() does lost ones.
    /// Throws LimitError if an image or all of them together are too large.
    void decode(std::span<const WantedLevel> wanted, Scene& scene);

    /// Frees the buffers in which no image lies: the document's accessors cannot be read any more.
    void free_buffers();

  private:
    void replace_lost(Scene& scene);

    Document& document_;
    const LoadOptions& options_;
    std::unique_ptr<ImageWork> work_;
};

/// Decodes all images of the file, and reports those that are missing or damaged, or that are KTX2.
/// Throws LimitError as GltfImages::decode does.
void check_images(Document& document, const LoadOptions& options);

}  // namespace sightline
