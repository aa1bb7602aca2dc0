#pragma once
// The referee on refraction at a smooth boundary.

namespace sightline {

/// Refraction of light at a dielectric, with eta = n_transmitted / n_incident.
struct ExactRefraction {
    bool total;          ///< total internal reflection: exactly if eta² − 1 + cos_i² ≤ 0
    double cos_t;        ///< of the refracted direction, to double precision; 0 if total
    double reflectance;  ///< Fresnel's, unpolarised, to nearly double precision
};

/// For 0 ≤ cos_i ≤ 1 and eta > 0.
ExactRefraction exact_refraction(float cos_i, float eta);

}  // namespace sightline
