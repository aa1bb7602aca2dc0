#pragma once
// A material with the textures that it uses, bound to their images.
#include "shade/hit_geometry.h"
#include "shade/surface.h"

namespace sightline {

/// A material's use of a texture, ready to be sampled.
struct BoundTexture {
    const TextureImage* image = nullptr;
    const Texture* sampler = nullptr;
    uint32_t texcoord = 0;
    bool transformed = false;
    Vec2 across{1, 0}, down{0, 1}, offset{0, 0};  ///< uv' = u·across + v·down + offset

    uint32_t lookup = none;  ///< id of the lookup, which several textures of a material may share

    explicit operator bool() const { return image != nullptr; }
    /// True if a lookup in this texture is a lookup in the other.
    bool shares_lookup(const BoundTexture& other) const;
};

/// Reads the textures of one material at one hit; refers to the hit.
class TextureReader {
  public:
    /// Filters what a cone of rays along the unit vector `direction`, `width` wide at the hit in
    /// world units, covers of the surface, widened by `least`, a part of the image's width and
    /// height; if both are 0, the texture is read at full resolution.
    TextureReader(const HitGeometry& hit, const Vec3& direction, float width, float least = 0)
        : geometry(hit), direction_(direction), width_(width), least2_(least * least) {}

    Vec4 operator()(const BoundTexture& texture);

    const HitGeometry& geometry;

  private:
    TextureFootprint footprint(const BoundTexture& texture);

    Vec3 direction_;
    float width_, least2_;
    uint32_t set_ = none;        // texture coordinates of across_
    UvGradients across_;         // of the coordinates across the cone, times its width
    uint32_t lookup_id_ = none;  // BoundTexture::lookup of lookup_
    TextureLookup lookup_{};
};

/// The textures that shading reads. Occlusion textures are ignored: shadows are traced.
enum class TextureSlot {
    base_color,
    metallic_roughness,
    normal,
    emissive,
    transmission,
    specular,
    specular_color,
    glossiness,
    clearcoat,
    clearcoat_roughness,
    clearcoat_normal,
    sheen_color,
    sheen_roughness,
    anisotropy,
    iridescence,
    iridescence_thickness,
    diffuse_transmission,
    diffuse_transmission_color,
    count
};

/// A material ready for shading. Refers to the scene and to the images.
struct CompiledMaterial {
    const Material* material = nullptr;
    uint32_t features = 0;
    bool culls_back = false;  ///< the back is not drawn
    bool needs_uv = false;    ///< reads texture coordinates or tangents
    std::array<BoundTexture, static_cast<size_t>(TextureSlot::count)> textures;

    const BoundTexture& texture(TextureSlot slot) const {
        return textures[static_cast<size_t>(slot)];
    }

    /// Binds the texture to the slot.
    void bind(TextureSlot slot, BoundTexture texture);

    Vec4 base_color(TextureReader& read) const;
    /// Coverage from the base colour's alpha, by the alpha mode.
    float coverage(float alpha) const;
    Vec3 emission(TextureReader& read) const;
    /// Sets the members that depend on the material; the frame is set already.
    void shade(TextureReader& read, Surface& s, Faces faces) const;

  private:
    float factor(TextureSlot slot, int channel, float value, TextureReader& read) const;
    Vec3 color(TextureSlot slot, const Vec3& value, TextureReader& read) const;
    void shade_extensions(TextureReader& read, Surface& s) const;
};

/// The features that `material` uses, of MaterialFeature.
uint32_t material_features(const Material& material);

/// A texture reference of a material.
struct SlotTexture {
    TextureSlot slot;
    const TextureRef* ref;  ///< may be empty
    bool srgb;              ///< its colours are sRGB-encoded
};
std::array<SlotTexture, static_cast<size_t>(TextureSlot::count)> slot_textures(
    const Material& material);

}  // namespace sightline
