#pragma once
// What shading needs to know where a ray met the scene.
#include "core/ray.h"
#include "scene/scene.h"
#include "shade/texture.h"

#include <memory>

namespace sightline {

/// What a material has beyond glTF's metallic-roughness core; what is absent costs nothing.
enum MaterialFeature : uint32_t {
    feature_transmission = 1 << 0,
    feature_volume = 1 << 1,  ///< transmission through a closed boundary: light is refracted
    feature_clearcoat = 1 << 2,
    feature_sheen = 1 << 3,
    feature_anisotropy = 1 << 4,
    feature_iridescence = 1 << 5,
    feature_diffuse_transmission = 1 << 6,
    feature_specular = 1 << 7,  ///< KHR_materials_specular
    feature_unlit = 1 << 8,     ///< emission holds the base colour, nothing else is lit
};

/// The features that `material` uses.
uint32_t material_features(const Material& material);

/// The point, its frames and its material with all textures applied. World space; unit vectors.
struct Surface {
    Vec3 position;
    Vec3 position_error;  ///< bound of |computed − exact| for each coordinate
    Vec3 lift{0, 0,
              0};  ///< from position to just over the smooth surface that vertex normals describe
    Vec3 wo;       ///< towards where the ray came from
    Vec3 ng;       ///< geometric normal, on wo's side
    Vec3 ns;  ///< shading normal (interpolated, mapped): the mirror direction of wo is above ng
    Vec3 coat_normal;   ///< the clear coat's
    Vec3 tangent;       ///< orthogonal to ns, along growing u; only where anisotropic
    bool front = true;  ///< the ray met the outside
    uint32_t material = 0;
    uint32_t features = 0;  ///< of MaterialFeature

    float alpha = 1;  ///< coverage: MASK gives 0 or 1; 0 where a back face is culled
    Vec3 emission{0, 0, 0};
    Vec3 base_color{1, 1, 1};
    float metallic = 0, roughness = 1;  ///< perceptual; GGX alpha = roughness²
    float ior = 1.5f;
    /// Refractive index beyond the surface over that on wo's side. at() assumes air around every
    /// volume; who tracks nested media sets it before the BSDF is asked.
    float eta = 1.5f;
    float specular = 1;
    Vec3 specular_color{1, 1, 1};
    float transmission = 0;
    float clearcoat = 0, clearcoat_roughness = 0;
    Vec3 sheen_color{0, 0, 0};
    float sheen_roughness = 0;
    float anisotropy = 0;  ///< along `tangent`, which the material's rotation has turned
    float iridescence = 0, iridescence_ior = 1.3f, iridescence_thickness = 400;  ///< nm
    float diffuse_transmission = 0;
    Vec3 diffuse_transmission_color{1, 1, 1};

    bool has(MaterialFeature feature) const { return (features & feature) != 0; }
};

/// Evaluates surfaces of one scene; owns the prepared textures. Const calls are thread-safe.
class Surfaces {
  public:
    /// `mipmaps` false keeps textures at full resolution only. `scene` must outlive it.
    /// Images are prepared on `threads` threads (0: all).
    explicit Surfaces(const Scene& scene, bool mipmaps = true, unsigned threads = 0);
    ~Surfaces();

    /// The surface at a hit. `footprint` is the diameter in world units of what one sample covers
    /// there (a ray cone's width), for texture filtering.
    Surface at(const Ray& ray, const Hit& hit, float footprint) const;

    /// Coverage at a hit: 1 for OPAQUE, 0 or 1 for MASK, the material's alpha for BLEND; 0 for the
    /// back of a single-sided material without transmission, which glTF does not draw.
    float alpha(const Hit& hit, const Ray& ray) const;

    /// Colour of the light that passes straight through at a hit, for shadow rays: what alpha and
    /// transmission (less Fresnel's reflection at the ray's angle) let by; (0,0,0) for opaque.
    /// Culled back faces cast shadows all the same. A volume's attenuation is the caller's: it
    /// knows the distance between entry and exit.
    Vec3 transmittance(const Hit& hit, const Ray& ray) const;

    /// Light that the material gives off at a point of a mesh triangle (not attenuated by a coat);
    /// `footprint` in world units.
    Vec3 emission(const Hit& hit, float footprint) const;

    /// TEXCOORD_0 at a hit, untransformed.
    Vec2 texcoord(const Ray& ray, const Hit& hit) const;

    size_t texture_memory() const;

  private:
    struct Prepared;
    const Scene& scene_;
    std::vector<std::unique_ptr<TextureImage>> linear_, srgb_;  // by image index
    std::vector<Prepared> materials_;
};

/// A ray that leaves a surface on the side of `direction`, from an origin moved by the position's
/// error bound so that it cannot meet the surface it starts from (pbrt's error-bounded offset).
Ray spawn_ray(const Surface& surface, const Vec3& direction, float tfar);

/// A shadow ray towards a light. Where normals are interpolated it starts over the smooth surface,
/// which hides the facets' shadow terminator (Hanika 2021, "Hacking the Shadow Terminator").
Ray spawn_shadow_ray(const Surface& surface, const Vec3& direction, float tfar);

}  // namespace sightline
