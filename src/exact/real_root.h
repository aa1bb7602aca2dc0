#pragma once
// Real algebraic numbers: a polynomial and an interval that contains exactly one of its roots.
// Private to src/exact.
#include "exact/polynomial.h"

#include <utility>

namespace sightline {

/// One real root, comparable exactly with the roots of other polynomials.
class RealRoot {
  public:
    /// The root of the square-free `p` in (low, high]; there must be exactly one.
    RealRoot(IntegerPolynomial p, Dyadic low, Dyadic high, int multiplicity)
        : polynomial_(std::move(p)),
          low_(std::move(low)),
          high_(std::move(high)),
          multiplicity_(multiplicity) {}
    /// The rational number numerator/denominator.
    RealRoot(const Dyadic& numerator, const Dyadic& denominator);

    int multiplicity() const { return multiplicity_; }

    /// The nearest double (or the next nearest, if the root lies within 2^-100 of halfway between).
    double to_double();

    /// −1, 0, 1. Narrows the intervals of both.
    friend int compare(RealRoot& a, RealRoot& b);

  private:
    bool is_exact() const { return compare(low_, high_) == 0; }
    void narrow();
    void set_ends(std::pair<Dyadic, Dyadic> low, std::pair<Dyadic, Dyadic> high);

    IntegerPolynomial polynomial_;
    Dyadic low_, high_;  // the root lies in (low, high]; equal ends: it is that number
    int multiplicity_ = 1;
    bool has_values_ = false;
    Dyadic low_value_, high_value_;  // of the polynomial at the ends, once narrowed
    mp_bitcnt_t bits_ = 1;           // the next step divides the interval into 2^bits parts
};

/// The roots of p in (low, high], ascending, with their multiplicities. p must not be zero.
/// No `high` means no end.
std::vector<RealRoot> real_roots(const IntegerPolynomial& p, const Dyadic& low, const Dyadic* high);

}  // namespace sightline
