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

    explicit operator bool() const { return image != nullptr; }
    /// `footprint` in world units.
    Vec4 sample(const HitGeometry& g, float footprint) const;
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

    Vec4 base_color(const HitGeometry& g, float footprint) const;
    /// Base colour's alpha as the alpha mode reads it.
    float coverage(float alpha) const;
    float metallic(const HitGeometry& g, float footprint) const;
    float transmission(const HitGeometry& g, float footprint) const;
    Vec3 emission(const HitGeometry& g, float footprint) const;
    /// Fills what depends on the material; the frame is set already.
    void shade(const HitGeometry& g, float footprint, Surface& s) const;

  private:
    float factor(Slot slot, int channel, float value, const HitGeometry& g, float footprint) const;
    Vec3 color(Slot slot, const Vec3& value, const HitGeometry& g, float footprint) const;
    void shade_extensions(const HitGeometry& g, float footprint, Surface& s) const;
};

/// The texture references of a material by slot, and whether their colours are sRGB-encoded.
struct SlotUse {
    Slot slot;
    const TextureRef* ref;
    bool srgb;
};
std::array<SlotUse, static_cast<size_t>(Slot::count)> texture_uses(const Material& material);

}  // namespace sightline
