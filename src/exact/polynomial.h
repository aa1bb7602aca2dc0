#pragma once
// Integer polynomials in one variable and their real roots, exactly. Private to src/exact.
// Sturm's theorem, Yun's square-free factors: von zur Gathen and Gerhard, Modern Computer Algebra,
// sections 4.7 and 14.6.
#include "exact/dyadic.h"

#include <vector>

namespace sightline {

/// Coefficients from the constant term upwards; the last is not zero. Empty: the zero polynomial.
using IntegerPolynomial = std::vector<mpz_class>;

/// The same with dyadic coefficients, for assembling a surface's equation.
class DyadicPolynomial {
  public:
    DyadicPolynomial(std::vector<Dyadic> coefficients) : coefficients_(std::move(coefficients)) {}
    explicit DyadicPolynomial(Dyadic constant) : coefficients_{std::move(constant)} {}

    friend DyadicPolynomial operator+(const DyadicPolynomial& a, const DyadicPolynomial& b);
    friend DyadicPolynomial operator-(const DyadicPolynomial& a, const DyadicPolynomial& b);
    friend DyadicPolynomial operator*(const DyadicPolynomial& a, const DyadicPolynomial& b);

    /// A positive multiple with integer coefficients: it has the same roots and signs.
    IntegerPolynomial integer() const;

  private:
    std::vector<Dyadic> coefficients_;
};

IntegerPolynomial derivative(const IntegerPolynomial& p);

/// A greatest common divisor without common factors in its coefficients; leading one positive.
IntegerPolynomial gcd(const IntegerPolynomial& a, const IntegerPolynomial& b);

Dyadic value_at(const IntegerPolynomial& p, const Dyadic& x);

/// The sign of p(x).
int sign_at(const IntegerPolynomial& p, const Dyadic& x);

/// p's square-free factors: the roots of element i are p's roots of multiplicity i + 1.
std::vector<IntegerPolynomial> square_free_factors(const IntegerPolynomial& p);

/// Sturm's chain of a square-free polynomial, which counts roots.
class SturmChain {
  public:
    explicit SturmChain(const IntegerPolynomial& p);

    /// The number of distinct real roots in (low, high].
    int count(const Dyadic& low, const Dyadic& high) const;

  private:
    int variations(const Dyadic& x) const;

    std::vector<IntegerPolynomial> chain_;
};

/// A power of two that no root exceeds in magnitude (Cauchy's bound).
Dyadic root_bound(const IntegerPolynomial& p);

}  // namespace sightline
