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

double rounded_quotient(const mpz_class& numerator, const mpz_class& denominator) {
    mpq_class quotient(numerator, denominator);
    quotient.canonicalize();
    mpfr_t rounded;
    mpfr_init2(rounded, 53);
    mpfr_set_q(rounded, quotient.get_mpq_t(), MPFR_RNDN);
    const double result = mpfr_get_d(rounded, MPFR_RNDN);
    mpfr_clear(rounded);
    return result;
}

double rounded_quotient(const Dyadic& numerator, const Dyadic& denominator) {
    const long shift = numerator.exponent() - denominator.exponent();
    const auto bits = static_cast<mp_bitcnt_t>(std::abs(shift));
    if (shift >= 0)
        return rounded_quotient(mpz_class(numerator.mantissa() << bits), denominator.mantissa());
    return rounded_quotient(numerator.mantissa(), mpz_class(denominator.mantissa() << bits));
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
