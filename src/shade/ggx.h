#pragma once
// The GGX distribution of microfacet normals (Walter et al. 2007) with Smith's height-correlated
// masking (Heitz 2014), isotropic or stretched along a tangent.
#include "core/math.h"

namespace sightline {

/// Two unit vectors that complete the unit vector `n` (Duff et al. 2017, "Building an Orthonormal
/// Basis, Revisited").
inline void complete_basis(const Vec3& n, Vec3& t, Vec3& b) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1 / (sign + n.z), c = n.x * n.y * a;
    t = {1 + sign * n.x * n.x * a, sign * c, -sign * n.x};
    b = {c, sign + n.y * n.y * a, -n.y};
}

/// A GGX lobe around `normal`.
class Ggx {
  public:
    Ggx(const Vec3& normal, float alpha) : n_(normal), ax_(alpha), ay_(alpha) {}
    /// `tangent` is orthogonal to `normal`.
    Ggx(const Vec3& normal, const Vec3& tangent, float along, float across)
        : n_(normal),
          t_(tangent),
          b_(cross(normal, tangent)),
          ax_(along),
          ay_(across),
          isotropic_(along == across) {}

    /// Density of microfacet normals at `h`, per solid angle and projected area.
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

    /// cos θ · (1 + 2Λ): the term of which masking is made, for a unit vector on either side.
    float slant(const Vec3& v) const {
        const float c = dot(n_, v);
        if (isotropic_) return std::sqrt(ax_ * ax_ * (1 - c * c) + c * c);
        const float x = dot(t_, v) * ax_, y = dot(b_, v) * ay_;
        return std::sqrt(x * x + y * y + c * c);
    }

    /// Density with which sample() picks normals that reflect wo to wi, per solid angle of wi.
    float reflection_pdf(const Vec3& h, float cos_o, float slant_o) const {
        return distribution(h) / (2 * (cos_o + slant_o));
    }

    /// A microfacet normal visible from wo, `u` in [0,1)² (Heitz 2018, "Sampling the GGX
    /// Distribution of Visible Normals").
    Vec3 sample(const Vec3& wo, Vec2 u) const;

  private:
    Vec3 n_, t_, b_;
    float ax_, ay_;
    bool isotropic_ = true;
};

/// G1 of Smith from |cos θ| and slant.
inline float smith_g1(float cosine, float slant) { return 2 * cosine / (cosine + slant); }

/// G2/G1(wo) of the height-correlated Smith term for reflection.
inline float smith_reflection_weight(float cos_o, float slant_o, float cos_i, float slant_i) {
    return cos_i * (cos_o + slant_o) / (cos_o * slant_i + cos_i * slant_o);
}

}  // namespace sightline
