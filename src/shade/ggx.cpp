#include "shade/ggx.h"

#include <algorithm>

namespace sightline {

Vec3 Ggx::sample(const Vec3& wo, Vec2 u) const {
    Vec3 t = t_, b = b_;
    if (isotropic_) complete_basis(n_, t, b);
    const Vec3 stretched = normalize(Vec3(ax_ * dot(t, wo), ay_ * dot(b, wo), dot(n_, wo)));
    // Axes of the disc. Its half that faces away is foreshortened along t2, so t1 is horizontal.
    const Vec3 horizontal(-stretched.y, stretched.x, 0);
    const float length2 = dot(horizontal, horizontal);
    const Vec3 t1 = length2 > 1e-12f ? horizontal * (1 / std::sqrt(length2)) : Vec3(1, 0, 0);
    const Vec3 t2 = cross(stretched, t1);

    const float r = std::sqrt(u.x), phi = 2 * pi * u.y;
    const float p1 = r * std::cos(phi);
    const float blend = 0.5f * (1 + stretched.z);
    const float disc = std::sqrt(std::max(0.0f, 1 - p1 * p1));
    const float p2 = (1 - blend) * disc + blend * r * std::sin(phi);
    const float p3 = std::sqrt(std::max(0.0f, 1 - p1 * p1 - p2 * p2));
    const Vec3 h = t1 * p1 + t2 * p2 + stretched * p3;
    return normalize(t * (ax_ * h.x) + b * (ay_ * h.y) + n_ * std::max(1e-6f, h.z));
}

}  // namespace sightline
