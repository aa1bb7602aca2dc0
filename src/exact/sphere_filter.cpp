#include "exact/sphere_filter.h"

#include "exact/shape_ray.h"

namespace sightline {
namespace {

/// The bounds of a quotient whose denominator is certainly not zero.
Enclosure quotient(const Bounded& p, const Bounded& q) {
    const double least = std::abs(q.value) - q.error, t = p.value / q.value;
    const double error =
        ((p.error + std::abs(t) * q.error) / least + std::abs(t) * 0x1p-52) * (1 + 0x1p-40);
    return {t - error - 0x1p-900, t + error + 0x1p-900};
}

Bounded root_of_positive(const Bounded& x) {
    const double root = std::sqrt(x.value);
    return {root, (x.error / root + root * 0x1p-52) * (1 + 0x1p-40)};
}

/// Adds a root if it lies within the segment. Returns false if that is not certain.
bool add(const Ray& ray, const Enclosure& t, RootEnclosures& roots) {
    const double near = exact_double(ray.tnear), far = exact_double(ray.tfar);
    if (t.high <= near || t.low > far) return true;
    if (!(t.low > near && t.high <= far)) return false;
    roots.t[static_cast<size_t>(roots.count++)] = t;
    return true;
}

}  // namespace

std::optional<RootEnclosures> enclose_sphere_roots(const Ray& ray, const InstancedShape& sphere) {
    BasicShapeRay<Bounded> local;
    if (!local.enter(ray, sphere)) return std::nullopt;
    // a t² + 2 b t + c = 0
    const Bounded r = local.length(sphere.shape->radius);
    const Bounded a = dot(local.direction, local.direction), b = dot(local.origin, local.direction),
                  c = dot(local.origin, local.origin) - r * r;
    const Bounded discriminant = b * b - a * c;
    const std::optional<int> sign = discriminant.sign();
    RootEnclosures roots;
    if (sign == -1) return roots;
    if (sign != 1 || a.sign() != 1) return std::nullopt;
    const Bounded root = root_of_positive(discriminant);
    // The sum of numbers of the same sign loses no digits.
    const Bounded q = b.value > 0 ? -(b + root) : root - b;
    if (!q.sign()) return std::nullopt;
    Enclosure first = quotient(c, q), second = quotient(q, a);
    if (second.low < first.low) std::swap(first, second);
    if (!(first.high < second.low)) return std::nullopt;  // also for NaN
    if (!add(ray, first, roots) || !add(ray, second, roots)) return std::nullopt;
    return roots;
}

}  // namespace sightline
