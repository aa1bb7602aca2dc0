#pragma once
// The GGX distribution of microfacet normals (Walter et al. 2007, section 5.4) with Smith's
// height-correlated masking (Heitz 2014, "Understanding the Masking-Shadowing Function in
// Microfacet-Based BRDFs"), isotropic or stretched along a tangent.
#include "core/math.h"

namespace sightline {

/// Completes the unit vector `n` to an orthonormal basis (Duff et al. 2017, "Building an
/// Orthonormal Basis, Revisited").
inline void complete_basis(const Vec3& n, Vec3& t, Vec3& b) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1 / (sign + n.z), c = n.x * n.y * a;
    t = {1 + sign * n.x * n.x * a, sign * c, -sign * n.x};
    b = {c, sign + n.y * n.y * a, -n.y};
}

/// A GGX lobe around the unit vector `normal`. Its alpha is the square of the perceptual roughness.
class Ggx {
  public:
    Ggx(const Vec3& normal, float alpha) : n_(normal), ax_(alpha), ay_(alpha) {}
    /// `tangent` is a unit vector orthogonal to `normal`; `along` and `across` it are alphas.
    Ggx(const Vec3& normal, const Vec3& tangent, float along, float across)
        : n_(normal),
          t_(tangent),
          b_(cross(normal, tangent)),
          ax_(along),
          ay_(across),
          isotropic_(along == across) {}

    /// D(h): area of the microfacets with unit normal `h`, per solid angle and area of the surface.
    float distribution(const Vec3& h) const {
        const float cos_h = dot(n_, h);
        // The sine by cross product: 1 − cos² has no bits left in narrow lobes.
        float stretched;
        if (isotropic_) {
            const Vec3 s = cross(n_, h);
            stretched = dot(s, s) / (ax_ * ax_);
        } else {
            const float x = dot(t_, h) / ax_, y = dot(b_, h) / ay_;
            stretched = x * x + y * y;
        }
        const float d = stretched + cos_h * cos_h;
        return 1 / (pi * ax_ * ay_ * d * d);
    }

    /// |cos θ| (1 + 2Λ(v)), with Smith's Λ (Heitz 2014, equation 72), for a unit vector on either
    /// side.
    float smith_term(const Vec3& v) const {
        const float c = dot(n_, v);
        if (isotropic_) return std::sqrt(ax_ * ax_ * (1 - c * c) + c * c);
        const float x = dot(t_, v) * ax_, y = dot(b_, v) * ay_;
        return std::sqrt(x * x + y * y + c * c);
    }

    /// Pdf of the direction into which the normal `h` of sample() reflects wo, per solid angle:
    /// G1(wo) D(h) / (4 cos θo) (Heitz 2018, equation 17). `smith_o` is smith_term(wo).
    float reflection_pdf(const Vec3& h, float cos_o, float smith_o) const {
        return distribution(h) / (2 * (cos_o + smith_o));
    }

    /// A microfacet normal visible from wo, for `u` in [0,1)² (Heitz 2018, "Sampling the GGX
    /// Distribution of Visible Normals", appendix A).
    Vec3 sample(const Vec3& wo, Vec2 u) const;

  private:
    Vec3 n_, t_{0, 0, 0}, b_{0, 0, 0};
    float ax_, ay_;
    bool isotropic_ = true;
};

/// G1 = 1 / (1 + Λ), from |cos θ| and smith_term.
inline float smith_g1(float cosine, float smith_term) { return 2 * cosine / (cosine + smith_term); }

/// G2(wo, wi) / G1(wo) for reflection, with heights correlated (Heitz 2014, equation 99).
inline float smith_reflection_weight(float cos_o, float smith_o, float cos_i, float smith_i) {
    return cos_i * (cos_o + smith_o) / (cos_o * smith_i + cos_i * smith_o);
}

}  // namespace sightline
