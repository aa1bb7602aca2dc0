#pragma once
#include "core/ray.h"

#include <random>

namespace sightline {

/// Random numbers of the atlas. The sequence is the same on every machine as long as no expression
/// draws twice, because the order of evaluation within an expression is not defined.
class Rng {
  public:
    explicit Rng(uint64_t seed) : engine_(seed) {}

    /// Uniform in [low, high).
    double uniform(double low, double high) {
        return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
    }
    /// Each coordinate uniform in [−half_size, half_size).
    Vec3d in_cube(double half_size) {
        const double x = uniform(-half_size, half_size), y = uniform(-half_size, half_size);
        return {x, y, uniform(-half_size, half_size)};
    }
    /// A uniform direction of length 1.
    Vec3d direction() {
        for (;;) {
            const Vec3d v = in_cube(1);
            const double length2 = dot(v, v);
            if (length2 > 0.01 && length2 <= 1) return v / std::sqrt(length2);
        }
    }
    /// A uniform direction with a length in [low, high).
    Vec3d direction(double low, double high) {
        const double length = uniform(low, high);
        return direction() * length;
    }
    /// An index in [0, n).
    uint32_t below(size_t n) { return static_cast<uint32_t>(engine_() % n); }
    bool coin() { return (engine_() >> 40 & 1) != 0; }
    /// 1 or −1.
    double sign() { return coin() ? 1 : -1; }

  private:
    std::mt19937_64 engine_;
};

/// A ray from the point `from`, rounded to floats, towards `target`, as closely as the floats of
/// its direction allow. It reaches the target at t = 1, where many operations happen to be exact,
/// or at a t of 0.5 to 2.
inline Ray aimed_ray(const Vec3d& from, const Vec3d& target, Rng& rng) {
    const Vec3 origin(from);
    const double length = rng.coin() ? 1 : rng.uniform(0.5, 2);
    return {origin, 0, Vec3((target - Vec3d(origin)) * length)};
}

}  // namespace sightline
