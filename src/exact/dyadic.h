#pragma once
// Exact arithmetic on dyadic rationals, which floats are: an integer times a power of two. Private
// to src/exact.
#include "core/math.h"
#include "exact/bounded.h"

#include <gmpxx.h>

namespace sightline {

/// mantissa · 2^exponent. Sums, differences and products are exact.
class Dyadic {
  public:
    Dyadic() = default;
    Dyadic(mpz_class mantissa, long exponent)
        : mantissa_(std::move(mantissa)), exponent_(exponent) {}
    /// The value of a finite double.
    explicit Dyadic(double value);

    const mpz_class& mantissa() const { return mantissa_; }
    long exponent() const { return exponent_; }
    int sign() const { return sgn(mantissa_); }
    mpq_class rational() const;

    friend Dyadic operator-(const Dyadic& a) { return {-a.mantissa_, a.exponent_}; }
    friend Dyadic operator+(const Dyadic& a, const Dyadic& b);
    friend Dyadic operator-(const Dyadic& a, const Dyadic& b) { return a + (-b); }
    friend Dyadic operator*(const Dyadic& a, const Dyadic& b) {
        return {a.mantissa_ * b.mantissa_, a.exponent_ + b.exponent_};
    }
    friend int compare(const Dyadic& a, const Dyadic& b) { return (a - b).sign(); }

  private:
    mpz_class mantissa_ = 0;
    long exponent_ = 0;
};

using Vec3e = Imath::Vec3<Dyadic>;

inline Dyadic exact_dyadic(float value) { return Dyadic(exact_double(value)); }
inline Vec3e exact_vector(const Vec3& v) {
    return {exact_dyadic(v.x), exact_dyadic(v.y), exact_dyadic(v.z)};
}

/// The double nearest to numerator/denominator, ties to even.
double rounded_quotient(const mpz_class& numerator, const mpz_class& denominator);
double rounded_quotient(const Dyadic& numerator, const Dyadic& denominator);

/// component/√length2, correctly rounded with a probability of about 1 − 2^-140.
double rounded_cosine(const Dyadic& component, const Dyadic& length2);

}  // namespace sightline
