#pragma once
// Which levels of its textures' pyramids a picture can read at all.
#include "intersect/intersector.h"
#include "render/settings.h"

#include <array>
#include <span>
#include <vector>

namespace sightline {

/// How densely the images of a scene lie on its surfaces, from which follows the finest level of
/// each that a view can read. A ray that arrives at a surface has come at least the straight way
/// from the camera, and its cone never narrows: on a mesh at distance d from the camera, the cone
/// of every ray is at least as wide as that of a camera ray after d. That bounds the level that a
/// triangle needs from below, and the pixels that it covers from above. Of each image,
///
/// - the level B is the finest that its triangles need, but for those that need the finest ones and
///   together cover at most a share of `ignored_share` of the picture: a texture is often stretched
///   over a few slivers, which would decide otherwise;
/// - the level S is the finest that camera rays read, but for the same share of them;
/// - the level wanted is S, but neither finer than B nor more than `hidden_levels` coarser: what
///   only mirrored and refracted rays see, such as a badly stretched inside, is read that much
///   coarser at most. S costs rays, so it is found only if it can save large images.
///
/// Where a lookup wants a finer level than is kept, it reads the finest that is. Emission is wanted
/// at least as finely as emitters are sampled, emitter_footprint. An image is wanted whole if it is
/// read without a footprint, by shadow rays or as an emitter behind a coat; if its sampler has no
/// mipmaps; if a shape shows it; and if it is read both as colours and as numbers.
class TextureLevels {
  public:
    static constexpr double ignored_share = 2e-4;
    static constexpr int hidden_levels = 2;
    static constexpr int coarsest = 16;

    /// `sizes`: by image, width and height; zeros: the image is wanted whole. The materials' images
    /// may still be encoded.
    TextureLevels(const Scene& scene, std::span<const std::array<int, 2>> sizes);

    /// By image: the finest level that a picture with these settings reads. `scene` is that of the
    /// constructor; `intersector` is that of its picture, or null: then S is not known, and B is
    /// wanted.
    std::vector<WantedLevel> wanted(const Scene& scene, const RenderSettings& settings,
                                    const Intersector* intersector = nullptr) const;

  private:
    /// A texture of a material, as far as it decides on density.
    struct TextureUse {
        uint32_t image, texcoord;
        Vec2 across, down;  // of a unit of u and v, in texels

        bool operator==(const TextureUse&) const = default;
    };
    /// Triangles of about one density: the least of them, in texels per length along any direction,
    /// and their area, both in the mesh's space. Of triangles that are stretched the lookup reads
    /// several probes, each as wide as a tenth of the longer axis at least.
    struct Part {
        double texels, area;
    };
    struct MeshUse {
        std::vector<TextureUse> textures;      // of its material, not whole
        std::vector<std::vector<Part>> parts;  // by texture
        Box3 bounds;                           // in the mesh's space
        float reach;  // largest distance of a vertex from the centre of the scene, if baked
    };
    /// How much of a picture needs each level of an image: pixels or rays.
    using Shares = std::array<double, coarsest + 1>;
    class Cones;

    static std::vector<TextureUse> uses_of(const Scene& scene, const Material& material,
                                           std::span<const std::array<int, 2>> sizes,
                                           std::vector<WantedLevel>& largest,
                                           std::vector<bool>& is_numbers);
    static double density(const Mesh& mesh, const std::array<uint32_t, 3>& corners,
                          const TextureUse& use);
    static std::vector<Part> parts_of(const Mesh& mesh, const TextureUse& use);
    std::vector<Shares> bounds(const Scene& scene, const Cones& cones) const;
    std::vector<Shares> seen(const Scene& scene, const RenderSettings& settings, const Cones& cones,
                             const Intersector& intersector) const;
    void count_seen(const Scene& scene, const Cones& cones, const Intersector& intersector,
                    std::vector<Ray> rays, std::vector<Shares>& shares) const;
    void count_hit(const Scene& scene, const Cones& cones, const Ray& ray, const Hit& hit,
                   std::vector<Shares>& shares) const;

    std::vector<MeshUse> meshes_;            // by mesh
    std::vector<std::array<int, 2>> sizes_;  // by image
    std::vector<WantedLevel> largest_;       // by image: the coarsest; 0: it is wanted whole
};

}  // namespace sightline
