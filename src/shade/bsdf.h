#pragma once
// glTF's material model: evaluation for light that is sampled, and the rays that it sends on.
#include "shade/fresnel.h"
#include "shade/surface.h"

#include <array>

namespace sightline {

/// Direction refracted by Snell's law (unit vectors, `n` on wo's side); false at total reflection.
bool refract(const Vec3& wo, const Vec3& n, float eta, Vec3& refracted);

/// Mirror direction of wo at n.
inline Vec3 reflect(const Vec3& wo, const Vec3& n) { return n * (2 * dot(wo, n)) - wo; }

/// Perceptual roughness below which a lobe is a perfect mirror: traced, not sampled.
inline constexpr float smooth_roughness = 0.03f;

/// Refractive index of every clear coat (KHR_materials_clearcoat).
inline constexpr float coat_ior = 1.5f;

/// What the surface reflects or transmits of light arriving from wi, times |cos|.
struct BsdfValue {
    Vec3 diffuse{0, 0,
                 0};  ///< lobes that are only lit directly (Lambert, sheen, diffuse transmission)
    Vec3 glossy{0, 0, 0};  ///< rough GGX lobes, which secondary rays sample too
    float glossy_pdf = 0;  ///< solid-angle density with which sample_secondary picks wi
};
/// Smooth lobes are zero here. Media are those of Surface::eta.
BsdfValue evaluate_bsdf(const Surface& surface, const Vec3& wi);

/// A ray that the surface sends on.
struct SecondaryRay {
    Vec3 direction;
    Vec3 weight;             ///< f·|cos|/pdf, or the Fresnel-weighted colour of a smooth lobe
    float pdf = 0;           ///< 0: a smooth lobe
    bool refracted = false;  ///< crossed the surface
    bool enters_volume = false, leaves_volume = false;  ///< refracted through a thick boundary
};

/// At most one reflected and one refracted ray (Whitted 1980); returns how many. Smooth lobes give
/// their exact direction; rough ones are sampled by GGX visible normals (Heitz 2018) with
/// `u_reflect`, `u_refract` in [0,1)²; `u_lobe` chooses between a clear coat and what lies below.
int sample_secondary(const Surface& surface, Vec2 u_reflect, Vec2 u_refract, float u_lobe,
                     std::array<SecondaryRay, 2>& rays);

/// True where sample_secondary can give a ray whose pdf is not 0.
bool is_rough(const Surface& surface);

/// False where evaluate_bsdf is zero for every direction: of mirrors and clear glass.
bool scatters(const Surface& surface);

/// Largest weight that any secondary ray of the material can have (for the depth bound in needs).
float max_reflectance(const Material& material);

}  // namespace sightline
