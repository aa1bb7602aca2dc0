#pragma once
// Which levels of its textures' pyramids a picture can read at all.
#include "render/settings.h"

#include <array>
#include <span>
#include <vector>

namespace sightline {

/// How densely the images of a scene lie on its surfaces, from which follows the finest level of
/// each that a view can read. A ray that arrives at a surface has come at least the straight way
/// from the camera, and its cone never narrows: on a mesh at distance d from the camera, the cone
/// of every ray is at least as wide as that of a camera ray after d. An image is wanted whole if it
/// is read without a footprint, by shadow rays or as an emitter; if its sampler has no mipmaps; if
/// a shape shows it; and if it is read both as colours and as numbers.
class TextureLevels {
  public:
    /// `sizes`: by image, width and height; zeros: the image is wanted whole. The materials' images
    /// may still be encoded.
    TextureLevels(const Scene& scene, std::span<const std::array<int, 2>> sizes);

    /// By image: the finest level that a picture with these settings reads. `scene` is that of the
    /// constructor.
    std::vector<WantedLevel> wanted(const Scene& scene, const RenderSettings& settings) const;

  private:
    /// The least texels per length along any direction of a mesh's triangles, in its space. Of
    /// triangles that are stretched the lookup reads several probes, each as wide as a tenth of the
    /// longer axis at least.
    struct Density {
        uint32_t image;
        double texels;
    };
    struct MeshUse {
        std::vector<Density> densities;
        Box3 bounds;  ///< in the mesh's space
        float reach;  ///< largest distance of a vertex from the centre of the scene, if baked
    };
    std::vector<MeshUse> meshes_;       // by mesh
    std::vector<WantedLevel> largest_;  // by image: 0 if it is wanted whole
};

}  // namespace sightline
