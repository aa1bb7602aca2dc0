#pragma once
// A material with its textures bound, and only those that it uses.
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
    float stretch = 1;                            ///< mean growth of lengths in uv by them

    uint32_t lookup = none;  ///< equal for the textures of a material that share their lookups

    explicit operator bool() const { return image != nullptr; }
    /// Whether what is read for the one is what is read for the other.
    bool shares_lookup(const BoundTexture& other) const;
};

/// Reads the textures of one material at one hit.
class TextureReader {
  public:
    /// `footprint` in world units.
    TextureReader(const HitGeometry& hit, float footprint) : geometry(hit), footprint_(footprint) {}

    Vec4 operator()(const BoundTexture& texture);

    const HitGeometry& geometry;

  private:
    float footprint_;
    uint32_t known_ = none;  // BoundTexture::lookup of lookup_
    TextureLookup lookup_;
};

/// The textures that shading reads. Occlusion is not among them: shadows are traced.
enum class Slot {
    base_color,
    metallic_roughness,
    normal,
    emissive,
    transmission,
    specular,
    specular_color,
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

struct Surfaces::Prepared {
    const Material* material = nullptr;
    uint32_t features = 0;
    bool culls_back = false;    ///< the back is not drawn
    bool parametrised = false;  ///< it reads texture coordinates or tangents
    std::array<BoundTexture, static_cast<size_t>(Slot::count)> textures;

    const BoundTexture& texture(Slot slot) const { return textures[static_cast<size_t>(slot)]; }

    /// Puts the texture where the slot reads it.
    void bind(Slot slot, BoundTexture texture);

    Vec4 base_color(TextureReader& read) const;
    /// Base colour's alpha as the alpha mode reads it.
    float coverage(float alpha) const;
    float metallic(TextureReader& read) const;
    float transmission(TextureReader& read) const;
    Vec3 emission(TextureReader& read) const;
    /// Fills what depends on the material; the frame is set already.
    void shade(TextureReader& read, Surface& s) const;

  private:
    float factor(Slot slot, int channel, float value, TextureReader& read) const;
    Vec3 color(Slot slot, const Vec3& value, TextureReader& read) const;
    void shade_extensions(TextureReader& read, Surface& s) const;
};

/// The texture references of a material by slot, and whether their colours are sRGB-encoded.
struct SlotUse {
    Slot slot;
    const TextureRef* ref;
    bool srgb;
};
std::array<SlotUse, static_cast<size_t>(Slot::count)> texture_uses(const Material& material);

}  // namespace sightline
