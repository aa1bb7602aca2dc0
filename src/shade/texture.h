#pragma once
#include "scene/scene.h"

#include <vector>

namespace sightline {

/// The texels that a lookup interpolates and their weights: the same for all images of one size.
struct TextureLookup {
    /// Two texels along an axis, and the fraction towards the second.
    struct Taps {
        int first, second;
        float fraction;
    };
    struct Level {
        size_t index;  ///< in the pyramid
        Taps x, y;
    };
    Level fine, coarse;
    float blend = 0;  ///< towards `coarse`, which is not set if this is 0
};

/// One image with its mip levels, ready to be sampled. Colours that glTF stores as sRGB are
/// decoded to linear *before* they are filtered. Eight-bit images stay eight-bit at every level.
class TextureImage {
  public:
    /// `srgb`: the RGB channels are sRGB-encoded. `mipmaps`: build the pyramid (box filter in
    /// linear light). Refers to `image`, which must outlive it and must not be empty.
    TextureImage(const Image& image, bool srgb, bool mipmaps);
    TextureImage(Image&&, bool, bool) = delete;

    /// The lookup at uv (v down, as in glTF) under the sampler; `footprint`, the width in uv that
    /// one sample covers, chooses the mip level.
    TextureLookup locate(const Texture& sampler, Vec2 uv, float footprint) const;

    /// RGBA. Grey is copied to RGB; missing alpha is 1.
    Vec4 read(const TextureLookup& lookup) const;

    /// True if the images can share lookups.
    bool has_size_of(const TextureImage& other) const {
        return levels_.size() == other.levels_.size() &&
               levels_[0].width == other.levels_[0].width &&
               levels_[0].height == other.levels_[0].height;
    }

    /// Bytes beyond the image's own.
    size_t memory() const;

  private:
    /// One image of the pyramid; exactly one of `bytes` and `floats` is set.
    struct Level {
        int width, height;
        const uint8_t* bytes;
        const float* floats;
    };
    void build_pyramid();
    void build_byte_level(const Level& fine, const Level& coarse, uint8_t* bytes) const;
    void build_float_level(const Level& fine, const Level& coarse, float* floats) const;
    TextureLookup::Level locate(const Texture& sampler, size_t level, bool linear, Vec2 uv) const;
    Vec4 read(const TextureLookup::Level& lookup) const;

    int channels_;
    bool srgb_;
    float texels_per_uv_;
    std::vector<Level> levels_;          // the image itself first
    std::vector<uint8_t> byte_storage_;  // levels after the first
    std::vector<float> float_storage_;   // the same, and the first if it had to be decoded
};

/// Applies KHR_texture_transform.
Vec2 transform_uv(const TextureRef& ref, Vec2 uv);

}  // namespace sightline
