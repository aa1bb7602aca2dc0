#include "exact/dyadic.h"

#include <mpfr.h>

#include <algorithm>
#include <cassert>

namespace sightline {

Dyadic::Dyadic(double value) {
    assert(std::isfinite(value));
    int exponent = 0;
    const double fraction = std::frexp(value, &exponent);
    mantissa_ = std::ldexp(fraction, 53);  // an integer below 2^53
    exponent_ = exponent - 53;
    if (mantissa_ == 0) {
        exponent_ = 0;
        return;
    }
    const auto zeros = mpz_scan1(mantissa_.get_mpz_t(), 0);
    mantissa_ >>= zeros;
    exponent_ += static_cast<long>(zeros);
}

Dyadic operator+(const Dyadic& a, const Dyadic& b) {
    if (a.sign() == 0) return b;
    if (b.sign() == 0) return a;
    const long exponent = std::min(a.exponent_, b.exponent_);
    const auto shift = [&](const Dyadic& x) {
        return mpz_class(x.mantissa_ << static_cast<mp_bitcnt_t>(x.exponent_ - exponent));
    };
    return {shift(a) + shift(b), exponent};
}

mpq_class Dyadic::rational() const {
    mpq_class result(mantissa_);
    if (exponent_ >= 0) return result << static_cast<mp_bitcnt_t>(exponent_);
    return result >> static_cast<mp_bitcnt_t>(-exponent_);
}

namespace {

/// numerator/denominator · 2^shift. A division to 53 bits: a fraction would be reduced first, which
/// takes longer.
double rounded_quotient(const mpz_class& numerator, const mpz_class& denominator, long shift) {
    if (sgn(numerator) == 0) return 0;
    const auto bits = [](const mpz_class& x) {
        return std::max<mpfr_prec_t>(2, static_cast<mpfr_prec_t>(mpz_sizeinbase(x.get_mpz_t(), 2)));
    };
    mpfr_t p, q, rounded;
    mpfr_init2(p, bits(numerator));
    mpfr_init2(q, bits(denominator));
    mpfr_init2(rounded, 53);
    mpfr_set_z(p, numerator.get_mpz_t(), MPFR_RNDN);
    mpfr_set_z(q, denominator.get_mpz_t(), MPFR_RNDN);
    mpfr_div(rounded, p, q, MPFR_RNDN);
    mpfr_mul_2si(rounded, rounded, shift, MPFR_RNDN);
    const double result = mpfr_get_d(rounded, MPFR_RNDN);
    mpfr_clears(p, q, rounded, nullptr);
    return result;
}

}  // namespace

double rounded_quotient(const mpz_class& numerator, const mpz_class& denominator) {
    return rounded_quotient(numerator, denominator, 0);
}

double rounded_quotient(const Dyadic& numerator, const Dyadic& denominator) {
    return rounded_quotient(numerator.mantissa(), denominator.mantissa(),
                            numerator.exponent() - denominator.exponent());
}

double rounded_cosine(const Dyadic& component, const Dyadic& length2) {
    const mpq_class c = component.rational(), square = c * c / length2.rational();
    mpfr_t x;
    mpfr_init2(x, 200);
    mpfr_set_q(x, square.get_mpq_t(), MPFR_RNDN);
    mpfr_sqrt(x, x, MPFR_RNDN);
    const double result = mpfr_get_d(x, MPFR_RNDN);
    mpfr_clear(x);
    return component.sign() < 0 ? -result : result;
}

}  // namespace sightline
