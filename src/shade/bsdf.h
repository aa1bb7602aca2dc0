#pragma once
// The BSDF of glTF's material model (glTF 2.0 appendix B and the KHR_materials extensions): eval,
// sample and pdf. Directions are unit vectors that point away from the surface.
#include "shade/fresnel.h"
#include "shade/surface.h"

#include <array>

namespace sightline {

/// Refracts by Snell's law; `n` is the unit normal on wo's side, eta the index on the other side
/// over that on wo's. False at total internal reflection.
bool refract(const Vec3& wo, const Vec3& n, float eta, Vec3& refracted);

/// Mirror direction of wo at n.
inline Vec3 reflect(const Vec3& wo, const Vec3& n) { return n * (2 * dot(wo, n)) - wo; }

/// Perceptual roughness below which a lobe counts as smooth: it has one direction.
inline constexpr float smooth_roughness = 0.03f;

/// Refractive index of every clear coat (KHR_materials_clearcoat).
inline constexpr float coat_ior = 1.5f;

/// Value of the BSDF for one pair of directions, times |cos θi|, and its pdf.
struct BsdfEval {
    Vec3 diffuse{0, 0, 0};  ///< lobes that no ray samples: Lambert, sheen, diffuse transmission
    Vec3 glossy{0, 0, 0};   ///< rough GGX lobes, which sample_bsdf samples
    float pdf = 0;          ///< with which sample_bsdf picks wi, per solid angle
};

/// Evaluates the BSDF and its pdf for light from the unit direction `wi`, on either side, and the
/// surface's wo. Smooth lobes have neither value nor pdf here: their directions have probability 0.
/// surface.eta must be set for the media on both sides.
BsdfEval eval_bsdf(const Surface& surface, const Vec3& wi);

/// One sampled direction.
struct BsdfSample {
    Vec3 direction;
    Vec3 weight;             ///< f·|cos|/pdf, or the Fresnel-weighted colour of a smooth lobe
    float pdf = 0;           ///< as BsdfEval::pdf; 0 for a smooth lobe
    bool refracted = false;  ///< crosses the surface
    bool unbent = false;     ///< crosses it in the direction −wo
    bool enters_volume = false, leaves_volume = false;  ///< refracted through a thick boundary
};

/// Samples at most one reflected and one refracted direction (Whitted 1980) for the surface's wo;
/// returns how many. Smooth lobes give their exact direction; rough ones are sampled by GGX visible
/// normals (Heitz 2018) with `u_reflect` and `u_refract` in [0,1)². `u_lobe` in [0,1) chooses
/// between a clear coat and the base. Directions of a rough lobe that fall behind the horizon are
/// lost.
int sample_bsdf(const Surface& surface, Vec2 u_reflect, Vec2 u_refract, float u_lobe,
                std::array<BsdfSample, 2>& samples);

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

/// True if sample_bsdf can return a sample whose pdf is not 0.
bool is_rough(const Surface& surface);

/// False if eval_bsdf is zero for every direction: for mirrors and clear glass.
bool scatters(const Surface& surface);

/// Largest weight that a sample of the material can have, for the bound of the depth in needs.
float max_reflectance(const Material& material);

}  // namespace sightline
