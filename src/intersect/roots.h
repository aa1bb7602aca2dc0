#pragma once
// Real roots in an interval by recursion over critical points (Yuksel 2022, "High-Performance
// Polynomial Root Finding for Graphics", PACMCGIT 5(3)): between neighbouring critical points a
// function is monotone, so a change of sign there brackets exactly one root.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace sightline {

/// A function's value and derivative at one point.
struct ValueAndSlope {
    double value, slope;
};

/// Coefficients of a polynomial of degree N, lowest power first.
template <int N>
using Polynomial = std::array<double, N + 1>;

template <int N>
ValueAndSlope evaluate(const Polynomial<N>& p, double x) {
    ValueAndSlope s{p[N], 0};
    for (int i = N - 1; i >= 0; --i) {
        s.slope = s.slope * x + s.value;
        s.value = s.value * x + p[size_t(i)];
    }
    return s;
}

template <int N>
Polynomial<N - 1> derivative(const Polynomial<N>& p) {
    Polynomial<N - 1> d;
    for (size_t i = 0; i < N; ++i) d[i] = double(i + 1) * p[i + 1];
    return d;
}

template <int N, int M>
Polynomial<N + M> multiply(const Polynomial<N>& a, const Polynomial<M>& b) {
    Polynomial<N + M> product{};
    for (size_t i = 0; i <= N; ++i)
        for (size_t j = 0; j <= M; ++j) product[i + j] += a[i] * b[j];
    return product;
}

/// The root in [a, b] of a monotone function that is below zero at one end only, by Newton's
/// iteration kept inside the shrinking bracket by bisection. A step of 1e-10 is the last: the
/// error after it is of that step's square.
template <class Function>
double bracketed_root(const Function& f, double a, double b, bool below_at_a) {
    const double last_step = 1e-10 * (std::abs(a) + std::abs(b));
    double x = 0.5 * (a + b);
    for (int i = 0; i < 100; ++i) {
        const ValueAndSlope y = f(x);
        if (y.value == 0) return x;
        ((y.value < 0) == below_at_a ? a : b) = x;
        const double next = x - y.value / y.slope;
        if (std::abs(next - x) <= last_step) return std::clamp(next, a, b);
        x = next > a && next < b ? next : 0.5 * (a + b);
    }
    return x;
}

/// Roots of `f` in [lo, hi] given its `count` ascending critical points there, with multiplicity:
/// a maximum or minimum within `tolerance` of zero is a double root. Returns how many of `roots`
/// were written, at most count + 1 rounded to the parity of the ends' signs.
template <class Function>
int roots_between(const Function& f, const double* critical, int count, double lo, double hi,
                  double tolerance, double* roots) {
    int found = 0;
    double a = lo, value_a = f(lo).value;
    bool below_a = value_a < 0;
    for (int i = 0; i <= count; ++i) {
        const double b = i < count ? critical[i] : hi;
        const double value_b = f(b).value;
        const bool touches = i < count && std::abs(value_b) <= tolerance;
        const bool below_b = touches ? value_a > value_b : value_b < 0;
        if (below_a != below_b) {
            const bool forced_a = below_a != (value_a < 0), forced_b = below_b != (value_b < 0);
            roots[found++] = forced_a ? a : forced_b ? b : bracketed_root(f, a, b, below_a);
        }
        a = b, value_a = value_b, below_a = below_b;
    }
    return found;
}

/// The points at which the polynomial (N ≥ 2) changes sign in [lo, hi], ascending; at most N.
template <int N>
int sign_changes(const Polynomial<N>& p, double lo, double hi, double* roots) {
    if constexpr (N == 2) {
        const double half = -0.5 * p[1], discriminant = half * half - p[2] * p[0];
        if (!(discriminant > 0)) return 0;
        const double q = half + std::copysign(std::sqrt(discriminant), half);
        const double a = q / p[2], b = p[0] / q;
        int count = 0;
        for (const double x : {std::min(a, b), std::max(a, b)})
            if (x >= lo && x <= hi) roots[count++] = x;
        return count;
    } else {
        double critical[N - 1];
        const int count = sign_changes<N - 1>(derivative<N>(p), lo, hi, critical);
        return roots_between([&p](double x) { return evaluate<N>(p, x); }, critical, count, lo, hi,
                             0, roots);
    }
}

}  // namespace sightline
