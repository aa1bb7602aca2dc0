#pragma once
// Directional albedos of the lobes, from tables that are computed when the program is built
// (tools/make_albedo_tables.cpp): what a lobe returns of the light that it gets, so that what is
// lost can be given back and what lies below gets no more than what is left. `roughness` is
// perceptual.

namespace sightline {

/// The refractive index of every coat, and of materials without KHR_materials_ior. Look-ups for it
/// cost half as much.
inline constexpr float usual_ior = 1.5f;

/// What a GGX lobe with single scattering returns towards a direction.
struct GgxAlbedo {
    float albedo = 1;             ///< E, with a reflectance of 1
    float fresnel_cosine = 1;     ///< at which smooth microfacets would reflect the mean of E
    float fresnel = 0;            ///< mean of fresnel_dielectric over E
    float totally_reflected = 0;  ///< share of E at which reflection is total
};

/// Of a lobe of reflection above a dielectric. `eta`: the index on the other side over that on the
/// side of the light.
GgxAlbedo ggx_albedo(float cosine, float roughness, float eta);

/// E alone.
float white_ggx_albedo(float cosine, float roughness);

/// Of a smooth surface: E is 1.
GgxAlbedo smooth_albedo(float cosine, float eta);

/// Of a lobe with the alphas `along` and `across` a tangent, across ≤ along, for a direction whose
/// tangential part has the share `cos2_along`² = cos²φ along the tangent; eta ≥ 1.
GgxAlbedo stretched_ggx_albedo(float cosine, float cos2_along, float along, float across,
                               float eta);

/// What a rough boundary refracts, by single scattering.
struct RefractionAlbedo {
    float refractable;  ///< if Fresnel's reflectance were 0 below the critical angle
    float held_back;    ///< of which Fresnel's reflectance takes this
};
RefractionAlbedo refraction_albedo(float cosine, float roughness, float eta);

/// The sheen lobe (sheen.h), divided by the larger of 1 and its albedos for both directions, so
/// that it returns no more than it gets.
float bounded_sheen_lobe(float cos_i, float cos_o, float cos_h, float roughness);

/// Directional albedo of bounded_sheen_lobe.
float sheen_albedo(float cosine, float roughness);

}  // namespace sightline
