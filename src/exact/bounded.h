#pragma once
// The referee's filter: doubles with a proven bound of their error.
#include "core/math.h"

#include <bit>
#include <cmath>
#include <optional>

namespace sightline {

/// `value` as a double, even if the thread flushes denormal floats to zero.
inline double exact_double(float value) {
    const uint32_t bits = std::bit_cast<uint32_t>(value);
    if ((bits & 0x7f800000u) != 0) return static_cast<double>(value);
    const double magnitude = static_cast<double>(bits & 0x007fffffu) * 0x1p-149;
    return (bits >> 31) != 0 ? -magnitude : magnitude;
}

/// The largest float not above `x`, and the smallest not below.
inline float float_below(double x) {
    const float f = static_cast<float>(x);
    return static_cast<double>(f) <= x ? f : std::nextafter(f, -INFINITY);
}
inline float float_above(double x) { return -float_below(-x); }

/// An approximation and a bound of its absolute error, kept by running error analysis
/// (Higham, Accuracy and Stability of Numerical Algorithms, section 3.3).
/// Inputs must be finite; an overflow shows as an error that is not finite.
struct Bounded {
    double value = 0, error = 0;

    Bounded() = default;
    Bounded(double v, double e = 0) : value(v), error(e) {}

    /// −1, 0 or 1 if the bound proves it.
    std::optional<int> sign() const {
        if (value > error) return 1;
        if (value < -error) return -1;
        if (value == 0 && error == 0) return 0;
        return std::nullopt;
    }

    friend Bounded operator-(const Bounded& a) { return {-a.value, a.error}; }
    friend Bounded operator+(const Bounded& a, const Bounded& b) {
        const double sum = a.value + b.value;
        return {sum, (a.error + b.error + std::abs(sum) * unit) * growth};
    }
    friend Bounded operator-(const Bounded& a, const Bounded& b) { return a + (-b); }
    friend Bounded operator*(const Bounded& a, const Bounded& b) {
        const double product = a.value * b.value;
        double bound = std::abs(a.value) * b.error + std::abs(b.value) * a.error +
                       a.error * b.error + std::abs(product) * unit;
        const bool may_underflow = std::abs(product) < 0x1p-960 && (a.value != 0 || a.error != 0) &&
                                   (b.value != 0 || b.error != 0);
        if (may_underflow) bound += 0x1p-950;
        return {product, bound * growth};
    }

  private:
    static constexpr double unit = 0x1p-53;        ///< of round to nearest
    static constexpr double growth = 1 + 0x1p-49;  ///< covers the rounding of the bound itself
};

}  // namespace sightline
