#pragma once
// The BSDF of glTF's material model (glTF 2.0 appendix B and the KHR_materials extensions): eval,
// sample and pdf. Directions are unit vectors that point away from the surface.
//
// The layers are, from the top: coat, sheen, and the base, a mix of a metal with a dielectric
// boundary above a diffuse or transmitting interior. Each returns its directional albedo R(wo) and
// leaves 1 − R(wo) to what lies below, so that together they return no more than they get. A
// diffuse lobe has the weight A(wo) A(wi) / mean(A), where A is what all boundaries above it let
// through (Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks", "Diffuse");
// glossy lobes below a layer have A(wo), which is exact for smooth ones and reciprocal for none.
#include "shade/fresnel.h"
#include "shade/ggx.h"
#include "shade/reflectance.h"
#include "shade/surface.h"

#include <array>

namespace sightline {

/// Refracts by Snell's law; `n` is the unit normal on wo's side, eta the index on the other side
/// over that on wo's. False at total internal reflection.
bool refract(const Vec3& wo, const Vec3& n, float eta, Vec3& refracted);

/// Mirror direction of wo at n.
inline Vec3 reflect(const Vec3& wo, const Vec3& n) { return n * (2 * dot(wo, n)) - wo; }

/// Value of the BSDF for one pair of directions, times |cos θi|, and its pdf.
struct BsdfEval {
    Vec3 diffuse{0, 0, 0};  ///< lobes that no ray samples: Lambert and sheen
    Vec3 glossy{0, 0, 0};   ///< lobes that Bsdf::sample samples: rough GGX, diffuse transmission
    float pdf = 0;          ///< with which Bsdf::sample picks wi, per solid angle
};

/// One sampled direction.
struct BsdfSample {
    Vec3 direction{0, 0, 0};
    Vec3 weight{0, 0, 0};    ///< f·|cos|/pdf, or the Fresnel-weighted colour of a smooth lobe
    float pdf = 0;           ///< as BsdfEval::pdf; 0 for a smooth lobe
    bool refracted = false;  ///< crosses the surface
    bool unbent = false;     ///< crosses it in the direction −wo
    bool enters_volume = false, leaves_volume = false;  ///< refracted through a thick boundary
};

/// The BSDF for one surface and its wo.
class Bsdf {
  public:
    /// surface.eta must be set for the media on both sides. `surface` must outlive the BSDF.
    explicit Bsdf(const Surface& surface);

    const Surface& surface() const { return s_; }

    /// The BSDF and its pdf for light from the unit direction `wi`, on either side. Smooth lobes
    /// have neither value nor pdf here: their directions have probability 0.
    BsdfEval eval(const Vec3& wi) const;

    /// Samples at most one direction on wo's side and one on the other (Whitted 1980); returns how
    /// many. Smooth lobes give their exact direction; rough ones are sampled by GGX visible
    /// normals (Heitz 2018) with `u_reflect` and `u_refract` in [0,1)². `u_lobe` in [0,1) chooses
    /// between a clear coat and the base. Directions of a rough lobe that fall behind the horizon
    /// are lost.
    int sample(Vec2 u_reflect, Vec2 u_refract, float u_lobe,
               std::array<BsdfSample, 2>& samples) const;

    /// Weight of what is transmitted towards wo, as if it went straight on.
    Vec3 straight_transmission() const {
        return s_.base_color * (transmitted_ * s_.transmission * base_weight_);
    }

  private:
    GgxAlbedo base_albedo() const;
    void prepare_layers();
    void prepare_dielectric(const GgxAlbedo& lobe);
    void prepare_transmission();
    void prepare_diffuse();
    float boundary_scale(const GgxAlbedo& lobe) const;
    float diffuse_share_below(float cosine) const;
    float mean_diffuse_share_below() const;
    Vec3 base_reflectance(float cosine) const;

    void eval_diffuse(const Vec3& wi, BsdfEval& result) const;
    void eval_sheen(const Vec3& wi, const Vec3& h, BsdfEval& result) const;
    void eval_reflection(const Vec3& wi, BsdfEval& result) const;
    void eval_transmission(const Vec3& wi, BsdfEval& result) const;
    bool sample_smooth_reflection(float u_lobe, BsdfSample& sample) const;
    bool sample_rough_reflection(Vec2 u, float u_lobe, BsdfSample& sample) const;
    bool sample_transmission(Vec2 u, BsdfSample& sample) const;
    bool sample_refraction(Vec2 u, BsdfSample& sample) const;

    const Surface& s_;
    float cos_o_ = 1;             ///< of wo and the shading normal
    float mean_roughness_ = 1;    ///< of the base, perceptual
    float base_weight_ = 1;       ///< what coat and sheen leave of light towards wo
    float coat_weight_ = 0;       ///< albedo of the coat
    float coat_scale_ = 0;        ///< factor of the coat's lobe
    float coat_probability_ = 0;  ///< of sampling the coat's lobe instead of the base's
    Vec3 dielectric_scale_{0, 0, 0}, metal_scale_{0, 0, 0};  ///< factors of their reflectances
    float transmitted_ = 0;          ///< share of light towards wo from below the dielectric
    float transmission_scale_ = 0;   ///< factor of the transmitted lobe
    float diffuse_scale_ = 0;        ///< factor of diffuse_share_below(wi) and of diffuse lobes
    float diffuse_probability_ = 0;  ///< of sampling diffuse transmission instead of refraction
};

/// Bsdf::eval and Bsdf::sample for a surface that needs only one of them.
inline BsdfEval eval_bsdf(const Surface& surface, const Vec3& wi) { return Bsdf(surface).eval(wi); }
inline int sample_bsdf(const Surface& surface, Vec2 u_reflect, Vec2 u_refract, float u_lobe,
                       std::array<BsdfSample, 2>& samples) {
    return Bsdf(surface).sample(u_reflect, u_refract, u_lobe, samples);
}

/// The shares of light that cross a surface towards wo without a change of direction.
struct LayerTransmittance {
    Vec3 unbent{0, 0, 0};  ///< as rays do: where nothing covers, and by smooth lobes of sample_bsdf
    /// By transmission that bends or blurs, as if it went straight on: the model of shadows.
    Vec3 bent{0, 0, 0};
};

/// For alpha and the surface's wo; (0,0,0) if it is opaque. The attenuation in volumes is left to
/// the caller, which has their entry and exit.
LayerTransmittance layer_transmittance(const Surface& surface);

/// True if what the surface transmits keeps its direction: a sample that crosses it is unbent.
bool transmission_is_unbent(const Surface& surface);

/// True if Bsdf::sample can return a sample whose pdf is not 0.
bool is_rough(const Surface& surface);

/// False if Bsdf::eval is zero for every direction: for mirrors and clear glass.
bool scatters(const Surface& surface);

/// Largest weight that a sample of the material can have, for the bound of the depth in needs.
float max_reflectance(const Material& material);

}  // namespace sightline
