#include "exact/real_root.h"

#include <algorithm>
#include <cassert>

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

}  // namespace

RealRoot::RealRoot(const Dyadic& numerator, const Dyadic& denominator) {
    assert(denominator.sign() != 0);
    polynomial_ = DyadicPolynomial({-numerator, denominator}).integer();
    const Dyadic bound = root_bound(polynomial_);
    low_ = -bound;
    high_ = bound;
}

void RealRoot::halve() {
    if (compare(low_, high_) == 0) return;
    const Dyadic mid = middle(low_, high_);
    const int at_mid = sign_at(polynomial_, mid);
    if (at_mid == 0) {
        low_ = high_ = mid;
        return;
    }
    // The root is simple: the sign at `high`, unless it is zero, is the sign above the root.
    const int at_high = sign_at(polynomial_, high_);
    if (at_high == 0)
        low_ = high_;
    else if (at_mid == at_high)
        high_ = mid;
    else
        low_ = mid;
}

double RealRoot::to_double() {
    const auto is_narrow = [&] {
        const Dyadic width = high_ - low_;
        if (width.sign() == 0) return true;
        if (low_.sign() * high_.sign() <= 0) return compare(width, power_of_two(zero_exponent)) < 0;
        const Dyadic& least = low_.sign() > 0 ? low_ : high_;
        return compare(width * power_of_two(relative_bits), least.sign() < 0 ? -least : least) < 0;
    };
    while (!is_narrow()) halve();
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
        a.halve();
        b.halve();
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
