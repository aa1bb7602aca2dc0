#include "exact/polynomial.h"

#include <algorithm>
#include <cassert>

namespace sightline {
namespace {

void trim(IntegerPolynomial& p) {
    while (!p.empty() && p.back() == 0) p.pop_back();
}

/// Divides out the coefficients' positive common divisor.
void make_primitive(IntegerPolynomial& p) {
    mpz_class content = 0;
    for (const mpz_class& c : p) content = gcd(content, c);
    if (content > 1)
        for (mpz_class& c : p) mpz_divexact(c.get_mpz_t(), c.get_mpz_t(), content.get_mpz_t());
}

/// A positive multiple of a's remainder modulo b.
IntegerPolynomial remainder(IntegerPolynomial a, const IntegerPolynomial& b) {
    const mpz_class factor = abs(b.back());
    while (a.size() >= b.size()) {
        const size_t shift = a.size() - b.size();
        const mpz_class lead = b.back() < 0 ? mpz_class(-a.back()) : a.back();
        for (mpz_class& c : a) c *= factor;
        for (size_t i = 0; i < b.size(); ++i) a[i + shift] -= lead * b[i];
        trim(a);
    }
    make_primitive(a);
    return a;
}

/// a / b up to a positive factor, if b divides a over the rationals.
IntegerPolynomial quotient(IntegerPolynomial a, const IntegerPolynomial& b) {
    IntegerPolynomial result(a.size() - b.size() + 1);
    const mpz_class factor = abs(b.back());
    while (a.size() >= b.size()) {
        const size_t shift = a.size() - b.size();
        const mpz_class lead = b.back() < 0 ? mpz_class(-a.back()) : a.back();
        for (mpz_class& c : a) c *= factor;
        for (mpz_class& c : result) c *= factor;
        for (size_t i = 0; i < b.size(); ++i) a[i + shift] -= lead * b[i];
        result[shift] += lead;
        trim(a);
    }
    assert(a.empty());
    trim(result);
    make_primitive(result);
    return result;
}

std::vector<Dyadic> combine(const std::vector<Dyadic>& a, const std::vector<Dyadic>& b, bool add) {
    std::vector<Dyadic> result(std::max(a.size(), b.size()));
    for (size_t i = 0; i < a.size(); ++i) result[i] = a[i];
    for (size_t i = 0; i < b.size(); ++i) result[i] = add ? result[i] + b[i] : result[i] - b[i];
    return result;
}

}  // namespace

DyadicPolynomial operator+(const DyadicPolynomial& a, const DyadicPolynomial& b) {
    return combine(a.coefficients_, b.coefficients_, true);
}

DyadicPolynomial operator-(const DyadicPolynomial& a, const DyadicPolynomial& b) {
    return combine(a.coefficients_, b.coefficients_, false);
}

DyadicPolynomial operator*(const DyadicPolynomial& a, const DyadicPolynomial& b) {
    std::vector<Dyadic> result(a.coefficients_.size() + b.coefficients_.size() - 1);
    for (size_t i = 0; i < a.coefficients_.size(); ++i)
        for (size_t j = 0; j < b.coefficients_.size(); ++j)
            result[i + j] = result[i + j] + a.coefficients_[i] * b.coefficients_[j];
    return result;
}

IntegerPolynomial DyadicPolynomial::integer() const {
    long exponent = 0;
    for (const Dyadic& c : coefficients_) exponent = std::min(exponent, c.exponent());
    IntegerPolynomial result;
    for (const Dyadic& c : coefficients_)
        result.push_back(c.mantissa() << static_cast<mp_bitcnt_t>(c.exponent() - exponent));
    trim(result);
    make_primitive(result);
    return result;
}

IntegerPolynomial derivative(const IntegerPolynomial& p) {
    IntegerPolynomial result;
    for (size_t i = 1; i < p.size(); ++i) result.push_back(p[i] * static_cast<unsigned long>(i));
    return result;
}

IntegerPolynomial gcd(const IntegerPolynomial& a, const IntegerPolynomial& b) {
    IntegerPolynomial p = a, q = b;
    while (!q.empty()) {
        IntegerPolynomial r = remainder(std::move(p), q);
        p = std::move(q);
        q = std::move(r);
    }
    make_primitive(p);
    if (!p.empty() && p.back() < 0)
        for (mpz_class& c : p) c = -c;
    return p;
}

Dyadic value_at(const IntegerPolynomial& p, const Dyadic& x) {
    // With x = n·2^e: Horner's rule on p, scaled by a power of two if e < 0.
    const mpz_class& n = x.mantissa();
    const auto bits = static_cast<mp_bitcnt_t>(std::abs(x.exponent()));
    mpz_class value = 0;
    const mpz_class point = x.exponent() > 0 ? mpz_class(n << bits) : n;
    mp_bitcnt_t scale = 0;
    for (auto c = p.rbegin(); c != p.rend(); ++c) {
        value = value * point + (*c << scale);
        if (x.exponent() < 0 && c + 1 != p.rend()) scale += bits;
    }
    return {std::move(value), -static_cast<long>(scale)};
}

int sign_at(const IntegerPolynomial& p, const Dyadic& x) { return value_at(p, x).sign(); }

std::vector<IntegerPolynomial> square_free_factors(const IntegerPolynomial& p) {
    std::vector<IntegerPolynomial> factors;
    IntegerPolynomial repeated = gcd(p, derivative(p));
    IntegerPolynomial distinct = quotient(p, repeated);
    while (distinct.size() > 1) {
        // `distinct` holds each root of multiplicity ≥ i once, `repeated` the rest of them.
        IntegerPolynomial more = gcd(distinct, repeated);
        factors.push_back(quotient(distinct, more));
        repeated = quotient(repeated, more);
        distinct = std::move(more);
    }
    return factors;
}

SturmChain::SturmChain(const IntegerPolynomial& p) : chain_{p, derivative(p)} {
    while (chain_.back().size() > 1) {
        IntegerPolynomial next = remainder(chain_[chain_.size() - 2], chain_.back());
        for (mpz_class& c : next) c = -c;
        if (next.empty()) break;
        chain_.push_back(std::move(next));
    }
}

int SturmChain::variations(const Dyadic& x) const {
    int changes = 0, last = 0;
    for (const IntegerPolynomial& p : chain_) {
        const int sign = sign_at(p, x);
        if (sign * last < 0) ++changes;
        if (sign != 0) last = sign;
    }
    return changes;
}

int SturmChain::count(const Dyadic& low, const Dyadic& high) const {
    return variations(low) - variations(high);
}

Dyadic root_bound(const IntegerPolynomial& p) {
    size_t largest = 0;
    for (const mpz_class& c : p) largest = std::max(largest, mpz_sizeinbase(c.get_mpz_t(), 2));
    const size_t lead = mpz_sizeinbase(p.back().get_mpz_t(), 2);
    return {1, static_cast<long>(largest - lead) + 2};
}

}  // namespace sightline
