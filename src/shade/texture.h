#pragma once
#include "scene/scene.h"

#include <array>
#include <atomic>
#include <vector>

namespace sightline {

/// The part of a texture that one sample covers, an ellipse: J·Jᵀ for the Jacobian J of the
/// coordinates by the position across a cone of rays, in units of the cone's width. The lengths of
/// its axes are the roots of the matrix' eigenvalues. Zero is a single point.
struct TextureFootprint {
    float uu = 0, uv = 0, vv = 0;
};

/// The texels that a lookup interpolates and their weights: the same for all images of one size.
struct TextureLookup {
    /// Two texels along an axis, and the fraction towards the second.
    struct Taps {
        int first, second;
        float fraction;
    };
    /// A bilinear interpolation in one level of the pyramid, and its weight.
    struct Probe {
        uint32_t level;
        float weight;
        Taps x, y;
    };
    static constexpr int max_probes = 8;
    uint32_t count = 0;
    std::array<Probe, max_probes> probes;  ///< the first `count` are set
};

/// One image with its mip levels, ready to be sampled. Colours that glTF stores as sRGB are
/// decoded to linear *before* they are filtered. Eight-bit images stay eight-bit at every level.
class TextureImage {
  public:
    /// `srgb`: the RGB channels are sRGB-encoded. `mipmaps`: build the pyramid (box filter in
    /// linear light). Refers to `image`, which must outlive it and must not be empty. Levels finer
    /// than `image.level` are missing.
    TextureImage(const Image& image, bool srgb, bool mipmaps);
    TextureImage(Image&&, bool, bool) = delete;

    /// Finds the lookup at uv (v down, as in glTF) under the sampler. The shorter axis of the
    /// footprint chooses the mip level; along the longer one, if it is at least twice as long, lie
    /// two probes or more. Samplers without mipmaps have one probe at full resolution. In place of
    /// a level that is missing, the finest is read.
    void locate(const Texture& sampler, Vec2 uv, const TextureFootprint& footprint,
                TextureLookup& lookup) const;

    /// RGBA. Grey is copied to RGB; missing alpha is 1.
    Vec4 read(const TextureLookup& lookup) const;

    /// True if the images can share lookups.
    bool has_size_of(const TextureImage& other) const {
        return levels_.size() == other.levels_.size() && finest_ == other.finest_ &&
               levels_[0].width == other.levels_[0].width &&
               levels_[0].height == other.levels_[0].height;
    }

    /// How many lookups with a footprint wanted a level that is missing.
    uint64_t finer_lookups() const { return finer_lookups_; }

    /// Bytes beyond the image's own.
    size_t memory() const;

  private:
    /// One image of the pyramid; exactly one of `bytes` and `floats` is set unless it is missing.
    struct Level {
        int width, height;
        const uint8_t* bytes;
        const float* floats;
    };
    void build_pyramid();
    void build_byte_level(const Level& fine, const Level& coarse, uint8_t* bytes) const;
    void build_float_level(const Level& fine, const Level& coarse, float* floats) const;
    void place(TextureLookup::Probe& probe, const Texture& sampler, bool linear, Vec2 uv) const;
    template <class T, int Channels>
    Vec4 read(const TextureLookup& lookup) const;

    int channels_;
    uint32_t finest_;  // the first level that exists: the image itself
    bool srgb_;
    mutable std::atomic<uint64_t> finer_lookups_{0};
    std::vector<Level> levels_;          // by number, with the sizes of those that are missing
    std::vector<uint8_t> byte_storage_;  // levels after the image's
    std::vector<float> float_storage_;   // the same, and the image's if it had to be decoded
};

/// Applies KHR_texture_transform.
Vec2 transform_uv(const TextureRef& ref, Vec2 uv);

}  // namespace sightline
