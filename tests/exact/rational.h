#pragma once
// Rational numbers, polynomials over them and their real roots for the second opinion
// (second_opinion_test.cpp, second_opinion_shapes_test.cpp). Shares no code with src/exact: roots
// are isolated by Descartes' rule of signs on intervals (Collins and Akritas 1976), not by Sturm's
// chains.
#include "core/ray.h"

#include <gmpxx.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <vector>

namespace sightline::rational {

using Number = mpq_class;
using Point = std::array<Number, 3>;

inline Number number(double x) { return Number(x); }
inline Number number(float x) { return Number(static_cast<double>(x)); }
inline Point point(const Vec3& p) { return {number(p.x), number(p.y), number(p.z)}; }

/// The number of rays that a test judges: SIGHTLINE_SECOND_OPINION_RAYS or, without it, `usual`.
inline int wanted_rays(int usual) {
    const char* wanted = std::getenv("SIGHTLINE_SECOND_OPINION_RAYS");
    return wanted ? std::atoi(wanted) : usual;
}

/// The double nearest to a rational number, of two the even one, by trying both neighbours of GMP's
/// truncation.
inline double nearest_double(const Number& x) {
    const double truncated = x.get_d();
    double best = truncated;
    for (const double other :
         {std::nextafter(truncated, -INFINITY), std::nextafter(truncated, INFINITY)}) {
        const int order = cmp(abs(Number(other) - x), abs(Number(best) - x));
        const bool best_is_odd = (std::bit_cast<uint64_t>(best) & 1) != 0;
        if (order < 0 || (order == 0 && best_is_odd)) best = other;
    }
    return best;
}

/// Coefficients from the constant term upwards, the last not zero; empty: zero everywhere.
class Polynomial {
  public:
    Polynomial() = default;
    Polynomial(const Number& constant) : Polynomial(std::vector<Number>{constant}) {}
    explicit Polynomial(std::vector<Number> coefficients) : c_(std::move(coefficients)) {
        while (!c_.empty() && c_.back() == 0) c_.pop_back();
    }

    size_t size() const { return c_.size(); }
    bool is_zero() const { return c_.empty(); }
    const Number& operator[](size_t i) const { return c_[i]; }

    friend Polynomial operator+(const Polynomial& a, const Polynomial& b) {
        std::vector<Number> sum(std::max(a.size(), b.size()));
        for (size_t i = 0; i < a.size(); ++i) sum[i] += a[i];
        for (size_t i = 0; i < b.size(); ++i) sum[i] += b[i];
        return Polynomial(std::move(sum));
    }
    friend Polynomial operator*(const Polynomial& a, const Polynomial& b) {
        std::vector<Number> product(a.size() + b.size());
        for (size_t i = 0; i < a.size(); ++i)
            for (size_t j = 0; j < b.size(); ++j) product[i + j] += a[i] * b[j];
        return Polynomial(std::move(product));
    }
    friend Polynomial operator-(const Polynomial& a, const Polynomial& b) {
        return a + Polynomial(Number(-1)) * b;
    }

    Polynomial derivative() const {
        std::vector<Number> slopes;
        for (size_t i = 1; i < c_.size(); ++i) slopes.push_back(c_[i] * static_cast<int>(i));
        return Polynomial(std::move(slopes));
    }

    /// A multiple whose coefficients are whole numbers without a common divisor.
    Polynomial primitive() const {
        mpz_class denominators = 1, divisor = 0;
        for (const Number& c : c_) denominators = lcm(denominators, c.get_den());
        std::vector<mpz_class> whole;
        for (const Number& c : c_) whole.push_back(c.get_num() * (denominators / c.get_den()));
        for (const mpz_class& w : whole) divisor = gcd(divisor, w);
        std::vector<Number> result;
        for (const mpz_class& w : whole) result.emplace_back(w / divisor);
        return Polynomial(std::move(result));
    }

  private:
    std::vector<Number> c_;
};

/// Quotient and remainder; b is not zero.
inline std::pair<Polynomial, Polynomial> divide(const Polynomial& a, const Polynomial& b) {
    std::vector<Number> rest, quotient(a.size() < b.size() ? 0 : a.size() - b.size() + 1);
    for (size_t i = 0; i < a.size(); ++i) rest.push_back(a[i]);
    for (size_t k = quotient.size(); k-- > 0;) {
        quotient[k] = rest[k + b.size() - 1] / b[b.size() - 1];
        for (size_t i = 0; i < b.size(); ++i) rest[k + i] -= quotient[k] * b[i];
    }
    return {Polynomial(std::move(quotient)), Polynomial(std::move(rest))};
}

inline Polynomial common_divisor(Polynomial a, Polynomial b) {
    while (!b.is_zero()) {
        Polynomial rest = divide(a, b).second.primitive();
        a = std::move(b);
        b = std::move(rest);
    }
    return a;
}

/// The sign of a primitive polynomial.
inline int sign_at(const Polynomial& p, const Number& x) {
    mpz_class sum = 0, scale = 1;  // sum / scale, by Horner's rule
    for (size_t i = p.size(); i-- > 0;) {
        sum = sum * x.get_num() + p[i].get_num() * scale;
        scale *= x.get_den();
    }
    return sgn(sum);
}

/// The changes of sign in the coefficients of (1 + x)ⁿ p((low + high·x)/(1 + x)), for a primitive
/// p: as many as p has roots in the open interval, or an even number more; 0 and 1 are exact.
inline int sign_changes(const Polynomial& p, const Number& low, const Number& high) {
    const mpz_class unit = lcm(low.get_den(), high.get_den()),
                    start = low.get_num() * (unit / low.get_den()),
                    width = high.get_num() * (unit / high.get_den()) - start;
    std::vector<mpz_class> c;  // of unitⁿ p((start + width·x)/unit), by Horner's rule
    mpz_class scale = 1;
    for (size_t i = p.size(); i-- > 0;) {
        c.emplace_back(0);
        for (size_t k = c.size() - 1; k > 0; --k) c[k] = c[k] * start + c[k - 1] * width;
        c[0] = c[0] * start + p[i].get_num() * scale;
        scale *= unit;
    }
    std::reverse(c.begin(), c.end());  // xⁿ p(1/x), then x + 1 for x
    for (size_t i = 0; i < c.size(); ++i)
        for (size_t k = c.size() - 1; k > i; --k) c[k - 1] += c[k];
    int changes = 0, last = 0;
    for (const mpz_class& x : c) {
        if (sgn(x) * last < 0) ++changes;
        if (sgn(x) != 0) last = sgn(x);
    }
    return changes;
}

/// A real root of a polynomial without multiple roots: the only one in the open interval, or a
/// rational number.
class Root {
  public:
    explicit Root(const Number& exact) : low_(exact), high_(exact) {}
    Root(Polynomial p, const Number& low, const Number& high)
        : p_(std::move(p)), low_(low), high_(high), sign_(sign_at(p_, low)) {}

    bool is_exact() const { return low_ == high_; }

    void refine() {
        if (is_exact()) return;
        const Number middle = (low_ + high_) / 2;
        const int sign = sign_at(p_, middle);
        if (sign == 0) {
            low_ = high_ = middle;
        } else if (sign_ != 0 ? sign != sign_ : sign_changes(p_, low_, middle) == 1) {
            high_ = middle;
        } else {
            low_ = middle;
            sign_ = sign;
        }
    }

    /// The sign of a function at the root.
    int sign_of(const Polynomial& function) {
        if (function.is_zero()) return 0;
        const Polynomial q = function.primitive();
        if (is_exact()) return sign_at(q, low_);
        if (has_common_root(q, low_, high_)) return 0;
        while (!is_exact() && sign_changes(q, low_, high_) > 0) refine();
        return sign_at(q, (low_ + high_) / 2);
    }

    /// −1, 0, 1
    int compare(Root& other) {
        if (is_exact() && other.is_exact()) return cmp(low_, other.low_);
        if (other.is_exact()) return -other.compare(*this);
        if (is_exact()) {
            if (other.low_ < low_ && low_ < other.high_ && sign_at(other.p_, low_) == 0) return 0;
        } else {
            const Number low = std::max(low_, other.low_), high = std::min(high_, other.high_);
            if (low < high && has_common_root(other.p_, low, high)) return 0;
        }
        while (low_ < other.high_ && other.low_ < high_) {
            refine();
            other.refine();
        }
        if (is_exact() && other.is_exact()) return cmp(low_, other.low_);
        return high_ <= other.low_ ? -1 : 1;
    }

    /// Whether no double is nearer to the root; one that is halfway between two rounds to either.
    bool rounds_to(double x) {
        Root low((Number(x) + Number(std::nextafter(x, -INFINITY))) / 2),
            high((Number(x) + Number(std::nextafter(x, INFINITY))) / 2);
        return compare(low) >= 0 && compare(high) <= 0;
    }

  private:
    /// Whether the root, the only one of p_ in the interval if any, is one of q, too.
    bool has_common_root(const Polynomial& q, const Number& low, const Number& high) const {
        const Polynomial common = common_divisor(p_, q);
        return common.size() > 1 && sign_changes(common, low, high) % 2 != 0;
    }

    Polynomial p_;
    Number low_, high_;
    int sign_ = 0;  // of p_ at low_
};

/// Appends the roots of p, which has no multiple ones, in the open interval.
inline void isolate(const Polynomial& p, const Number& low, const Number& high,
                    std::vector<Root>& roots) {
    const int changes = sign_changes(p, low, high);
    if (changes == 0) return;
    if (changes == 1) {
        roots.emplace_back(p, low, high);
        return;
    }
    const Number middle = (low + high) / 2;
    isolate(p, low, middle, roots);
    if (sign_at(p, middle) == 0) roots.emplace_back(middle);
    isolate(p, middle, high, roots);
}

/// The distinct roots of a polynomial in (tnear, tfar]; none if it is zero everywhere.
inline std::vector<Root> roots_of(const Polynomial& equation, const Ray& ray) {
    std::vector<Root> roots;
    if (equation.size() < 2) return roots;
    const Number near = number(ray.tnear);
    if (equation.size() == 2) {
        const Number t = -equation[0] / equation[1];
        if (t > near && (std::isinf(ray.tfar) || t <= number(ray.tfar))) roots.emplace_back(t);
        return roots;
    }
    Polynomial p = equation.primitive();
    Number far = 1;
    if (std::isinf(ray.tfar)) {  // Cauchy's bound, as a power of two
        Number largest = near;
        for (size_t i = 0; i < p.size(); ++i)
            largest = std::max(largest, Number(abs(p[i] / p[p.size() - 1])));
        while (far <= largest + 1) far *= 2;
    } else {
        far = number(ray.tfar);
        if (sign_at(p, far) == 0) roots.emplace_back(far);
    }
    if (sign_changes(p, near, far) > 1) {
        const Polynomial repeated = common_divisor(p, p.derivative().primitive());
        if (repeated.size() > 1) p = divide(p, repeated).first.primitive();
    }
    isolate(p, near, far, roots);
    return roots;
}

}  // namespace sightline::rational
