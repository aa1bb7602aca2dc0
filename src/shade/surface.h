#pragma once
// What shading needs to know where a ray met the scene.
#include "core/ray.h"
#include "scene/scene.h"
#include "shade/texture.h"

#include <memory>

namespace sightline {

/// The point, its frames and its material with all textures applied. World space; unit vectors.
struct Surface {
    Vec3 position;
    Vec3 position_error;  ///< bound of |computed − exact| for each coordinate
    Vec3 wo;              ///< towards where the ray came from
    Vec3 ng;              ///< geometric normal, on wo's side
    Vec3 ns;              ///< shading normal (interpolated, mapped), on wo's side and dot(ns, wo) > 0
    Vec3 coat_normal;     ///< the clear coat's
    Vec3 tangent;         ///< orthogonal to ns; along growing u (for anisotropy)
    Vec2 uv;              ///< TEXCOORD_0, untransformed
    bool front = true;    ///< the ray met the outside
    uint32_t material = 0;

    float alpha = 1;  ///< coverage: MASK gives 0 or 1
    Vec3 emission{0, 0, 0};
    Vec3 base_color{1, 1, 1};
    float occlusion = 1;  ///< baked; multiplies nothing that is traced
    float metallic = 0, roughness = 1;  ///< perceptual; GGX alpha = roughness²
    float ior = 1.5f, specular = 1;
    Vec3 specular_color{1, 1, 1};
    float transmission = 0;
    bool thin = true;  ///< transmission without refraction (no thickness)
    float clearcoat = 0, clearcoat_roughness = 0;
    Vec3 sheen_color{0, 0, 0};
    float sheen_roughness = 0;
    float anisotropy = 0, anisotropy_rotation = 0;
    float iridescence = 0, iridescence_ior = 1.3f, iridescence_thickness = 400;  ///< nm
    float diffuse_transmission = 0;
    Vec3 diffuse_transmission_color{1, 1, 1};
    bool unlit = false;
};

/// Evaluates surfaces of one scene; owns the prepared textures. Const calls are thread-safe.
class Surfaces {
  public:
    /// `mipmaps` false keeps textures at full resolution only. `scene` must outlive it.
    explicit Surfaces(const Scene& scene, bool mipmaps = true);

    /// The surface at a hit. `footprint` is the diameter in world units of what one sample covers
    /// there (a ray cone's width), for texture filtering.
    Surface at(const Ray& ray, const Hit& hit, float footprint) const;

    /// Coverage at a hit: 1 for OPAQUE, 0 or 1 for MASK, the material's alpha for BLEND.
    float alpha(const Hit& hit, const Ray& ray) const;

    /// Colour of the light that passes straight through at a hit: what alpha and transmission let
    /// by (Fresnel at normal-incidence formula for the ray's angle); (0,0,0) for opaque.
    /// A volume's attenuation is the caller's: it knows the distance between entry and exit.
    Vec3 transmittance(const Hit& hit, const Ray& ray) const;

    size_t texture_memory() const;

  private:
    Vec4 sample(const TextureRef& ref, const Mesh* mesh, const Hit& hit, const Vec2& uv0,
                float footprint) const;
    const Scene& scene_;
    std::vector<std::unique_ptr<TextureImage>> linear_, srgb_;  // by image index
};

/// A ray that leaves a surface on the side of `direction`, from an origin moved by the position's
/// error bound so that it cannot meet the surface it starts from (pbrt's error-bounded offset).
Ray spawn_ray(const Surface& surface, const Vec3& direction, float tfar);

}  // namespace sightline
