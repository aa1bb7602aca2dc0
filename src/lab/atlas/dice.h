#pragma once
#include "core/ray.h"

#include <random>

namespace sightline {

/// Random numbers of the laboratory: the same sequence on every machine, so long as no expression
/// draws twice.
class Dice {
  public:
    explicit Dice(uint64_t seed) : random_(seed) {}

    /// Uniform in [low, high).
    double between(double low, double high) {
        return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
    }
    /// Each coordinate uniform in [−size, size).
    Vec3d vector(double size) {
        const double x = between(-size, size), y = between(-size, size);
        return {x, y, between(-size, size)};
    }
    /// A uniform direction of length 1.
    Vec3d direction() {
        for (;;) {
            const Vec3d v = vector(1);
            const double length2 = dot(v, v);
            if (length2 > 0.01 && length2 <= 1) return v / std::sqrt(length2);
        }
    }
    /// A uniform direction with a length in [low, high).
    Vec3d direction(double low, double high) {
        const double length = between(low, high);
        return direction() * length;
    }
    uint32_t below(size_t n) { return static_cast<uint32_t>(random_() % n); }
    bool coin() { return (random_() >> 40 & 1) != 0; }
    double sign() { return coin() ? 1 : -1; }

  private:
    std::mt19937_64 random_;
};

/// A ray from a point, rounded to floats, at another, as near as the direction's floats allow. Its
/// t there is 1, where many things happen to be exact, or about 0.5 to 2.
inline Ray aimed_ray(const Vec3d& from, const Vec3d& at, Dice& dice) {
    const Vec3 origin(from);
    const double length = dice.coin() ? 1 : dice.between(0.5, 2);
    return {origin, 0, Vec3((at - Vec3d(origin)) * length)};
}

}  // namespace sightline
