#pragma once
// The referee on refraction at a smooth boundary.

namespace sightline {

/// What light does that meets a dielectric at cos_i, with eta = n_transmitted / n_incident.
struct ExactRefraction {
    bool total;          ///< total internal reflection: exactly where eta² − 1 + cos_i² ≤ 0
    double cos_t;        ///< of the refracted direction, to double precision; 0 where total
    double reflectance;  ///< Fresnel's, unpolarised, to nearly double precision
};

/// For 0 ≤ cos_i ≤ 1 and eta > 0.
ExactRefraction exact_refraction(float cos_i, float eta);

}  // namespace sightline
