#pragma once
// The surface at a hit, ready for shading.
#include "exact/surface_id.h"
#include "scene/scene.h"
#include "shade/texture.h"

#include <memory>

namespace sightline {

/// Parts of a material beyond glTF's metallic-roughness core; absent ones cost nothing.
enum MaterialFeature : uint32_t {
    feature_transmission = 1 << 0,
    feature_volume = 1 << 1,  ///< transmission through a closed boundary, which refracts
    feature_clearcoat = 1 << 2,
    feature_sheen = 1 << 3,
    feature_anisotropy = 1 << 4,
    feature_iridescence = 1 << 5,
    feature_diffuse_transmission = 1 << 6,
    feature_specular = 1 << 7,  ///< KHR_materials_specular or _pbrSpecularGlossiness
    feature_unlit = 1 << 8,     ///< emission holds the base colour; no light is reflected
};

/// The point, its frames and its material with all textures applied. World space; unit vectors.
struct Surface {
    Vec3 position;
    Vec3 position_error;  ///< bound of |computed − exact| for each coordinate
    /// From position to the smooth surface that vertex normals describe.
    Vec3 shadow_terminator_offset{0, 0, 0};
    Vec3 wo;  ///< towards the ray's origin
    Vec3 ng;  ///< geometric normal, on wo's side
    Vec3 ns;  ///< shading normal (interpolated, mapped): the mirror direction of wo is above ng
    Vec3 bend{0, 0, 0};  ///< ns less the interpolated and mapped normal
    Vec3 coat_normal;    ///< the clear coat's
    Vec3 tangent;        ///< orthogonal to ns, along growing u; only if anisotropic
    bool front = true;   ///< the ray hit the outside
    SurfaceId id;
    uint32_t material = 0;
    uint32_t features = 0;  ///< of MaterialFeature

    float alpha = 1;  ///< coverage: 0 or 1 for MASK; 0 for culled back faces
    Vec3 emission{0, 0, 0};
    Vec3 base_color{1, 1, 1};
    float metallic = 0, roughness = 1;  ///< perceptual; GGX alpha = roughness²
    float ior = 1.5f;
    /// Refractive index beyond the surface over that on wo's side. Surfaces::at assumes air around
    /// every volume; callers that track nested media set it before evaluating the BSDF.
    float eta = 1.5f;
    float specular = 1;
    Vec3 specular_color{1, 1, 1};
    float transmission = 0;
    float clearcoat = 0, clearcoat_roughness = 0;
    Vec3 sheen_color{0, 0, 0};
    float sheen_roughness = 0;
    float anisotropy = 0;  ///< along `tangent`, which includes the material's rotation
    float iridescence = 0, iridescence_ior = 1.3f, iridescence_thickness = 400;  ///< nm
    float diffuse_transmission = 0;
    Vec3 diffuse_transmission_color{1, 1, 1};

    /// The normal for diffuse light, which has no mirror direction to correct.
    Vec3 diffuse_normal() const { return ns - bend; }
    bool has(MaterialFeature feature) const { return (features & feature) != 0; }
};

/// Which faces of a surface count.
enum class Faces {
    drawn,  ///< rays go on behind the culled backs of single-sided materials
    all     ///< those cast shadows all the same
};

/// True if the backs of the material's faces are not drawn: it is single-sided, and no light is
/// refracted through it.
bool culls_back_faces(const Material& material);

struct CompiledMaterial;
struct HitGeometry;

/// The part of its image's width and height over which the emission of a sampled point is a mean.
/// Rays that hit an emitter read what their cones cover; both have the same mean over any part of
/// the emitter that is larger, and their weights come from one table (EmissiveMesh), so that they
/// add up to one.
inline constexpr float emitter_footprint = 1 / 500.0f;

/// Evaluates surfaces of one scene; owns the textures. Const calls are thread-safe.
class Surfaces {
  public:
    /// Without `mipmaps` textures have full resolution only. Images are prepared on `threads`
    /// threads (0: all). `scene` must outlive it.
    explicit Surfaces(const Scene& scene, bool mipmaps = true, unsigned threads = 0);
    ~Surfaces();

    /// The surface at a hit. `footprint` is the width of the ray cone there in world units, for
    /// texture filtering.
    Surface at(const Ray& ray, const Hit& hit, float footprint, Faces faces = Faces::drawn) const;

    /// Radiance that a mesh triangle sends back along the ray, at a hit with this geometry and its
    /// texture coordinates: emission times coverage, attenuated by a coat. Without a coat, emission
    /// is a mean over emitter_footprint.
    Vec3 emission(const HitGeometry& geometry, const Hit& hit, const Ray& ray) const;

    /// Estimated luminance of the emission of a mesh triangle times its coverage, the mean over a
    /// part around the hit whose edges are `size` times the triangle's. Affects
    /// noise alone: textures are filtered even if their sampler is not, and MASK counts as its mean
    /// alpha.
    float mean_emission(const Hit& hit, float size) const;

    /// False if meshes of the material emit nothing: unlit, without emission, or black by texture.
    bool may_emit(uint32_t material) const { return filtered_[material] != nullptr; }

    /// TEXCOORD_0 at a hit, untransformed.
    Vec2 texcoord(const Ray& ray, const Hit& hit) const;

    size_t texture_memory() const;

    /// How many lookups with a footprint wanted a level of a texture that is missing.
    uint64_t finer_lookups() const;

  private:
    void prepare_emission();

    const Scene& scene_;
    std::vector<std::unique_ptr<TextureImage>> linear_, srgb_;  // by image index
    std::vector<CompiledMaterial> materials_;
    // For mean_emission: the textures of the scene with samplers that take means, and the materials
    // that emit, by index.
    std::vector<Texture> filtered_textures_;
    std::vector<std::unique_ptr<CompiledMaterial>> filtered_;
};

/// A ray that leaves a surface on the side of `direction`. Its origin is offset by the bound of the
/// position's error, so that it cannot hit that surface again (pbrt, 4th ed., section 6.8.6).
Ray spawn_ray(const Surface& surface, const Vec3& direction, float tfar);

/// A shadow ray in the unit direction of a light, to its point at `distance` from the surface. If
/// normals are interpolated it starts above the smooth surface, which hides the shadow terminator
/// of the triangles (Hanika 2021, "Hacking the Shadow Terminator").
Ray spawn_shadow_ray(const Surface& surface, const Vec3& direction, float distance);

}  // namespace sightline
