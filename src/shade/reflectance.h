#pragma once
// Fresnel reflectance of glTF's materials: of a microfacet, and its mean over a lobe.
#include "shade/albedo.h"
#include "shade/surface.h"

#include <array>

namespace sightline {

/// Perceptual roughness below which a lobe counts as smooth: it has one direction.
inline constexpr float smooth_roughness = 0.03f;

inline bool is_smooth(float roughness) { return roughness < smooth_roughness; }

/// Refractive index of every clear coat (KHR_materials_clearcoat).
inline constexpr float coat_ior = usual_ior;

/// Of a microfacet of the dielectric: glTF 2.0 appendix B with the exact Fresnel equations in place
/// of Schlick's fit, KHR_materials_specular and KHR_materials_iridescence.
Vec3 dielectric_reflectance(const Surface& s, float cosine);

/// Of a microfacet of the metal: Schlick's fit, and iridescence.
Vec3 metal_reflectance(const Surface& s, float cosine);

/// Mean of dielectric_reflectance over what a lobe reflects.
Vec3 mean_dielectric_reflectance(const Surface& s, const GgxAlbedo& lobe);

/// How much the light that microfacets scatter several times adds to a lobe with single scattering,
/// in the lobe's shape, for the reflectance `f0` along the normal (Turquin 2019, "Practical
/// Multiple Scattering Compensation for Microfacet Models", equation 16).
inline Vec3 multiple_scattering(const Vec3& f0, float albedo) {
    return Vec3(1) + f0 * ((1 - albedo) / albedo);
}

/// multiple_scattering of the dielectric's lobe and of the metal's.
Vec3 dielectric_multiple_scattering(const Surface& s, const GgxAlbedo& lobe);
Vec3 metal_multiple_scattering(const Surface& s, const GgxAlbedo& lobe);

/// The largest component of the reflectance of smooth microfacets, without iridescence, where
/// fresnel_dielectric is `fresnel`.
float largest_reflectance(const Surface& s, float fresnel, float cosine);

/// Albedo of a lobe above the dielectric with multiple scattering: its largest component, without
/// iridescence.
float plain_albedo(const Surface& s, const GgxAlbedo& lobe);

/// Cosines and weights of a mean over the cosine-weighted hemisphere (Gauss and Legendre's rule).
inline constexpr size_t mean_nodes = 6;
using NodeValues = std::array<float, mean_nodes>;
inline constexpr NodeValues mean_cosines{0.0337652f, 0.1693953f, 0.3806904f,
                                         0.6193096f, 0.8306047f, 0.9662348f};
inline constexpr NodeValues mean_weights{0.0057848f, 0.0611113f, 0.1781304f,
                                         0.2897836f, 0.2996503f, 0.1655396f};

/// Albedos at mean_cosines, from tables that the first call computes: plain_albedo without
/// KHR_materials_specular for an index of 1 to last_table_ior, coat_albedo, sheen_albedo.
inline constexpr float last_table_ior = 2.9f;
NodeValues plain_albedos(float roughness, float eta);
NodeValues coat_albedos(float roughness);
NodeValues sheen_albedos(float roughness);

/// The mean of plain_albedo over the cosine-weighted hemisphere, under the same conditions.
float mean_plain_albedo(float roughness, float eta);

/// The lobe of a coat.
GgxAlbedo coat_lobe_albedo(float cosine, float roughness);

/// Albedo of a coat that covers everything.
float coat_albedo(const GgxAlbedo& lobe);
inline float coat_albedo(float cosine, float roughness) {
    return coat_albedo(coat_lobe_albedo(cosine, roughness));
}

}  // namespace sightline
