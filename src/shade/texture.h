#pragma once
#include "scene/scene.h"

#include <array>

namespace sightline {

/// One image with its mip levels, ready to be sampled. Colours that glTF stores as sRGB are
/// decoded to linear *before* they are filtered.
class TextureImage {
  public:
    /// `srgb`: the RGB channels are sRGB-encoded. `mipmaps`: build the pyramid (box filter in
    /// linear light). Refers to `image`, which must outlive it.
    TextureImage(const Image& image, bool srgb, bool mipmaps);

    /// RGBA at uv (v down, as glTF) under the sampler; `footprint` is the width in uv that one
    /// sample covers, for the choice of the mip level. Grey is spread to RGB; missing alpha is 1.
    Vec4 sample(const Texture& sampler, Vec2 uv, float footprint) const;

    size_t memory() const;

  private:
    struct Level {
        int width, height;
        std::vector<uint8_t> bytes;  // empty on level 0: the image's own
        std::vector<float> floats;
    };
    Vec4 texel(int level, int x, int y) const;
    Vec4 bilinear(const Texture& sampler, int level, Vec2 uv) const;
    Vec4 nearest(const Texture& sampler, int level, Vec2 uv) const;

    const Image& image_;
    bool srgb_;
    std::vector<Level> levels_;
};

/// uv after KHR_texture_transform.
Vec2 transform_uv(const TextureRef& ref, Vec2 uv);

}  // namespace sightline
