#include "exact/real_root.h"

#include <algorithm>
#include <cassert>
#include <tuple>

namespace sightline {
namespace {

/// Far below the smallest double, 2^-1074: an interval around zero this wide rounds to zero.
constexpr long zero_exponent = -1200;
/// Any other interval is narrowed to this fraction of the root.
constexpr long relative_bits = 100;

Dyadic power_of_two(long exponent) { return Dyadic(mpz_class(1), exponent); }

Dyadic middle(const Dyadic& a, const Dyadic& b) { return (a + b) * power_of_two(-1); }

/// Appends the roots of the square-free p in (low, high], ascending.
void isolate(const IntegerPolynomial& p, const SturmChain& chain, int multiplicity,
             const Dyadic& low, const Dyadic& high, std::vector<RealRoot>& roots) {
    const int count = chain.count(low, high);
    if (count == 0) return;
    if (count == 1) {
        roots.emplace_back(p, low, high, multiplicity);
        return;
    }
    const Dyadic mid = middle(low, high);
    isolate(p, chain, multiplicity, low, mid, roots);
    isolate(p, chain, multiplicity, mid, high, roots);
}

/// The part, of 2^bits, in which the chord between values of different signs is zero.
mpz_class part_of_chord(const Dyadic& low, const Dyadic& high, mp_bitcnt_t bits) {
    const Dyadic whole = high - low;
    const long shift = low.exponent() - whole.exponent() + static_cast<long>(bits);
    mpz_class numerator = abs(low.mantissa()), denominator = abs(whole.mantissa());
    if (shift >= 0)
        numerator <<= static_cast<mp_bitcnt_t>(shift);
    else
        denominator <<= static_cast<mp_bitcnt_t>(-shift);
    const mpz_class part = numerator / denominator, last = (mpz_class(1) << bits) - 1;
    return part < last ? part : last;
}

}  // namespace

RealRoot::RealRoot(const Dyadic& numerator, const Dyadic& denominator) {
    assert(denominator.sign() != 0);
    polynomial_ = DyadicPolynomial({-numerator, denominator}).integer();
    const Dyadic bound = root_bound(polynomial_);
    low_ = -bound;
    high_ = bound;
}

/// Sets the ends, each with the polynomial's value there. A root at `high` becomes exact.
void RealRoot::set_ends(std::pair<Dyadic, Dyadic> low, std::pair<Dyadic, Dyadic> high) {
    std::tie(low_, low_value_) = std::move(low);
    std::tie(high_, high_value_) = std::move(high);
    if (high_value_.sign() == 0) low_ = high_;
}

/// One step of quadratic interval refinement (Abbott 2006, arXiv:1203.1227): divides the interval
/// and tries the part in which the chord between the ends has its root. While that is right, the
/// number of correct bits doubles with each step.
void RealRoot::narrow() {
    if (is_exact()) return;
    if (!std::exchange(has_values_, true))
        set_ends({low_, value_at(polynomial_, low_)}, {high_, value_at(polynomial_, high_)});
    if (is_exact()) return;
    // A root at `low` is not this one, and says nothing about it: the first half may be right.
    const bool chord = low_value_.sign() != 0;
    const mp_bitcnt_t bits = chord ? bits_ : 1;
    const Dyadic step = (high_ - low_) * power_of_two(-static_cast<long>(bits));
    const mpz_class part = chord ? part_of_chord(low_value_, high_value_, bits) : mpz_class(0);
    const auto point = [&](const mpz_class& k) {
        const Dyadic x = low_ + step * Dyadic(k, 0);
        return std::pair(x, value_at(polynomial_, x));
    };
    const auto low = std::pair(low_, low_value_), high = std::pair(high_, high_value_);
    // The root is simple: the sign at `high` is the sign above the root.
    const auto is_above = [&](const Dyadic& value) {
        return value.sign() == 0 || value.sign() == high.second.sign();
    };
    const auto left = part == 0 ? low : point(part);
    if (part != 0 && is_above(left.second)) {
        bits_ = std::max<mp_bitcnt_t>(1, bits / 2);
        return set_ends(low, left);
    }
    const auto right = point(part + 1);
    const bool found = is_above(right.second);
    bits_ =
        found ? std::min<mp_bitcnt_t>(2 * bits, relative_bits) : std::max<mp_bitcnt_t>(1, bits / 2);
    if (found) return set_ends(left, right);
    set_ends(right, high);
}

double RealRoot::to_double() {
    const auto is_narrow = [&] {
        const Dyadic width = high_ - low_;
        if (width.sign() == 0) return true;
        if (low_.sign() * high_.sign() <= 0) return compare(width, power_of_two(zero_exponent)) < 0;
        const Dyadic& least = low_.sign() > 0 ? low_ : high_;
        return compare(width * power_of_two(relative_bits), least.sign() < 0 ? -least : least) < 0;
    };
    while (!is_narrow()) narrow();
    return rounded_quotient(middle(low_, high_), Dyadic(1.0));
}

int compare(RealRoot& a, RealRoot& b) {
    bool may_be_equal = true;
    for (;;) {
        if (compare(a.high_, b.low_) <= 0 &&
            !(compare(a.high_, b.low_) == 0 && compare(b.low_, b.high_) == 0))
            return -1;
        if (compare(b.high_, a.low_) <= 0 &&
            !(compare(b.high_, a.low_) == 0 && compare(a.low_, a.high_) == 0))
            return 1;
        if (may_be_equal) {
            const IntegerPolynomial common = gcd(a.polynomial_, b.polynomial_);
            may_be_equal = false;
            if (common.size() > 1) {
                const Dyadic low = compare(a.low_, b.low_) > 0 ? a.low_ : b.low_;
                const Dyadic high = compare(a.high_, b.high_) < 0 ? a.high_ : b.high_;
                const bool shared = compare(low, high) == 0
                                        ? sign_at(common, low) == 0
                                        : SturmChain(common).count(low, high) > 0;
                if (shared) return 0;
            }
        }
        a.narrow();
        b.narrow();
    }
}

std::vector<RealRoot> real_roots(const IntegerPolynomial& p, const Dyadic& low,
                                 const Dyadic* high) {
    assert(!p.empty());
    std::vector<RealRoot> roots;
    if (p.size() == 1) return roots;
    const std::vector<IntegerPolynomial> factors = square_free_factors(p);
    for (size_t i = 0; i < factors.size(); ++i) {
        if (factors[i].size() < 2) continue;
        const Dyadic bound = root_bound(factors[i]);
        const Dyadic end = high != nullptr ? *high : bound;
        const Dyadic begin = compare(low, -bound) < 0 ? -bound : low;
        if (compare(begin, end) >= 0) continue;
        isolate(factors[i], SturmChain(factors[i]), static_cast<int>(i) + 1, begin, end, roots);
    }
    std::sort(roots.begin(), roots.end(), [](const RealRoot& a, const RealRoot& b) {
        RealRoot x = a, y = b;
        return compare(x, y) < 0;
    });
    return roots;
}

}  // namespace sightline
