#pragma once
#include "core/math.h"

namespace sightline {

/// Unpolarised Fresnel reflectance of a dielectric, exact (Cook and Torrance 1982, appendix);
/// eta = n_transmitted / n_incident, cos_i ≥ 0. 1 at total internal reflection, and for eta ≤ 0
/// (KHR_materials_ior's special value 0).
inline float fresnel_dielectric(float cos_i, float eta) {
    const float squared = eta * eta - 1 + cos_i * cos_i;
    if (squared <= 0 || eta <= 0) return 1;
    const float g = std::sqrt(squared);  // eta·cos_t
    const float a = g - cos_i, b = g + cos_i;
    const float ratio = a / b;
    const float p = (cos_i * b - 1) / (cos_i * a + 1);
    return 0.5f * ratio * ratio * (1 + p * p);
}

/// Reflectance in linear Rec. 709 of a thin film of `thickness` nm and index `film_ior` on a base
/// with reflectance `f0` at normal incidence, as in KHR_materials_iridescence (Belcour and Barla
/// 2017, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence").
Vec3 fresnel_thin_film(float cos_i, float film_ior, float thickness, const Vec3& f0);

}  // namespace sightline
