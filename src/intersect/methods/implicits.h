#pragma once
// Ray against f(p) = 0 for the sphere, the torus and the heart, each method over the scalar T.
// All work from an origin moved, in double, to the point of the line nearest the shape's centre:
// without that every solver is lost at a distance. All roots come in order, double ones once.
#include "core/math.h"
#include "scene/scene.h"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <vector>

namespace sightline {

/// f along a line: a polynomial of degree ≤ 6, coefficients from the constant term.
template <class T>
struct LinePolynomial {
    int degree = 0;
    std::array<T, 7> c{};

    T operator()(T t) const {
        T value = c[static_cast<size_t>(degree)];
        for (int i = degree; i-- > 0;) value = value * t + c[static_cast<size_t>(i)];
        return value;
    }

    /// A bound of the rounding error of (*this)(t), its coefficients' included (Higham, 5.1).
    T error(T t) const {
        T value = 0;
        for (int i = degree + 1; i-- > 0;)
            value = value * std::abs(t) + std::abs(c[static_cast<size_t>(i)]);
        return value * static_cast<T>(4 * degree) * std::numeric_limits<T>::epsilon();
    }

    LinePolynomial derivative() const {
        LinePolynomial slope;
        slope.degree = std::max(0, degree - 1);
        for (size_t i = 1; i <= static_cast<size_t>(degree); ++i)
            slope.c[i - 1] = c[i] * static_cast<T>(i);
        return slope;
    }

    friend LinePolynomial operator*(const LinePolynomial& a, const LinePolynomial& b) {
        LinePolynomial result;
        result.degree = a.degree + b.degree;
        for (size_t i = 0; i <= static_cast<size_t>(a.degree); ++i)
            for (size_t j = 0; j <= static_cast<size_t>(b.degree); ++j)
                result.c[i + j] += a.c[i] * b.c[j];
        return result;
    }
    friend LinePolynomial operator*(T s, LinePolynomial p) {
        for (T& coefficient : p.c) coefficient *= s;
        return p;
    }
    friend LinePolynomial operator+(LinePolynomial a, const LinePolynomial& b) {
        a.degree = std::max(a.degree, b.degree);
        for (size_t i = 0; i < a.c.size(); ++i) a.c[i] += b.c[i];
        return a;
    }
};

/// A shape's f along a line of unit speed from its closest approach, and the interval of its zeros.
template <class T>
struct ImplicitLine {
    LinePolynomial<T> f;
    T low = 0, high = 0;  ///< the shape's ball; low > high: missed
    double shift = 0;     ///< t of the new origin
    double scale = 1;     ///< t = shift + scale · (t of f)
};

/// Sets up the line in shape space (see Shape): sphere, torus or heart.
template <class T>
ImplicitLine<T> implicit_line(const Shape& shape, const Vec3d& origin, const Vec3d& direction) {
    const double speed = std::sqrt(dot(direction, direction));
    const Vec3d d = direction / speed;
    ImplicitLine<T> line;
    const double along = -dot(origin, d);
    line.shift = along / speed;
    line.scale = 1 / speed;
    const Vec3d o = origin + d * along;
    const auto sum = static_cast<double>(shape.radius + shape.tube_radius);
    const double bounding_radius =
        shape.kind == ShapeKind::sphere  ? static_cast<double>(shape.radius)
        : shape.kind == ShapeKind::torus ? sum
                                         : 1.5 * static_cast<double>(shape.scale);
    const double half2 = bounding_radius * bounding_radius - dot(o, o);
    line.high =
        half2 >= 0 ? static_cast<T>(std::sqrt(half2) * 1.0001 + bounding_radius * 1e-6) : T(-1);
    line.low = -line.high;

    using P = LinePolynomial<T>;
    const auto linear = [&](int i) { return P{1, {static_cast<T>(o[i]), static_cast<T>(d[i])}}; };
    const auto constant = [](double c) { return P{0, {static_cast<T>(c)}}; };
    const P x = linear(0), y = linear(1), z = linear(2), x2 = x * x, y2 = y * y, z2 = z * z;
    const auto r = static_cast<double>(shape.radius), tube = static_cast<double>(shape.tube_radius);
    const auto s = static_cast<double>(shape.scale);
    if (shape.kind == ShapeKind::sphere) line.f = x2 + y2 + z2 + constant(-r * r);
    if (shape.kind == ShapeKind::torus) {
        const P ball = x2 + y2 + z2 + constant(r * r - tube * tube);
        line.f = ball * ball + static_cast<T>(-4 * r * r) * (x2 + z2);
    }
    if (shape.kind == ShapeKind::heart) {
        const P ball = x2 + T(2.25) * z2 + y2 + constant(-s * s);
        line.f = ball * ball * ball + static_cast<T>(-s) * (y2 * y * (x2 + T(0.1125) * z2));
    }
    return line;
}

/// The zero of f between a and b, at which its signs differ.
template <class T>
T bisect(const LinePolynomial<T>& f, T a, T b) {
    const bool positive = f(b) > 0;
    for (;;) {
        const T middle = a + (b - a) / 2;
        if (middle <= std::min(a, b) || middle >= std::max(a, b)) return middle;
        ((f(middle) > 0) == positive ? b : a) = middle;
    }
}

/// Marches in 256 equal steps and bisects at changes of sign. Pairs of roots closer than a
/// step are lost, double roots with them unless a step lands on one.
template <class T>
std::vector<T> roots_by_marching(const LinePolynomial<T>& f, T low, T high) {
    std::vector<T> roots;
    constexpr int steps = 256;
    T last = low;
    for (int i = 1; i <= steps; ++i) {
        const T next = low + (high - low) * static_cast<T>(i) / static_cast<T>(steps);
        if (f(last) == 0)
            roots.push_back(last);
        else if ((f(last) > 0) != (f(next) > 0) && f(next) != 0)
            roots.push_back(bisect(f, last, next));
        last = next;
    }
    return roots;
}

/// Bounds of p over [a, b] by Taylor's form about the middle, widened by its rounding error.
template <class T>
std::pair<T, T> range_over(const LinePolynomial<T>& p, T a, T b) {
    const T middle = a + (b - a) / 2, radius = (b - a) / 2;
    T spread = 0, power = radius, factorial = 1;
    LinePolynomial<T> derivative = p;
    for (int i = 1; i <= p.degree; ++i) {
        derivative = derivative.derivative();
        factorial *= static_cast<T>(i);
        spread += std::abs(derivative(middle)) / factorial * power;
        power *= radius;
    }
    const T slack = p.error(std::max(std::abs(a), std::abs(b)));
    return {p(middle) - spread - slack, p(middle) + spread + slack};
}

/// Interval bisection (Mitchell, Robust Ray Intersection with Interval Arithmetic, GI 1990): parts
/// without a zero are dropped, monotone ones bisected; an interval that shrinks to nothing is a
/// double root.
template <class T>
std::vector<T> roots_by_intervals(const LinePolynomial<T>& f, T low, T high) {
    const LinePolynomial<T> slope = f.derivative();
    const T least =
        std::max(std::abs(low), std::abs(high)) * std::sqrt(std::numeric_limits<T>::epsilon());
    std::vector<T> roots;
    std::vector<std::pair<T, T>> parts = {{low, high}};
    while (!parts.empty()) {
        const auto [a, b] = parts.back();
        parts.pop_back();
        const auto [lowest, highest] = range_over(f, a, b);
        if (lowest > 0 || highest < 0) continue;
        const auto [flattest, steepest] = range_over(slope, a, b);
        if (flattest > 0 || steepest < 0) {
            if ((f(a) > 0) != (f(b) > 0)) roots.push_back(bisect(f, a, b));
        } else if (b - a < least) {
            const T middle = a + (b - a) / 2;
            if (roots.empty() || middle - roots.back() > 4 * least) roots.push_back(middle);
        } else {
            parts.emplace_back(a + (b - a) / 2, b);
            parts.emplace_back(a, a + (b - a) / 2);
        }
    }
    return roots;
}

/// Yuksel, High-Performance Polynomial Root Finding for Graphics, HPG 2022: between the roots of
/// the derivative f is monotone. An extremum that is zero within f's error bound is a double root.
template <class T>
std::vector<T> roots_by_isolation(const LinePolynomial<T>& f, T low, T high) {
    if (f.degree == 0) return {};
    std::vector<T> ends = roots_by_isolation(f.derivative(), low, high);
    ends.push_back(high);
    std::vector<T> roots;
    T last = low;
    bool touched = false;  // the interval's lower end was a double root
    for (const T end : ends) {
        const bool crosses = (f(last) > 0) != (f(end) > 0);
        const bool touches = end != high && std::abs(f(end)) <= f.error(end);
        if (crosses && !touches && !touched) roots.push_back(bisect(f, last, end));
        if (touches && !touched) roots.push_back(end);
        touched = touches;
        last = end;
    }
    return roots;
}

template <class T>
struct ImplicitMethod {
    std::string_view name;
    std::vector<T> (*roots)(const LinePolynomial<T>& f, T low, T high);
};

/// All methods by name.
template <class T>
std::span<const ImplicitMethod<T>> implicit_methods() {
    static constexpr ImplicitMethod<T> methods[] = {{"marching", roots_by_marching<T>},
                                                    {"interval", roots_by_intervals<T>},
                                                    {"isolation", roots_by_isolation<T>}};
    return methods;
}

/// All t at which the ray (in shape space) hits the sphere, torus or heart, ascending.
template <class T>
std::vector<double> implicit_roots(const ImplicitMethod<T>& method, const Shape& shape,
                                   const Vec3d& origin, const Vec3d& direction) {
    const ImplicitLine<T> line = implicit_line<T>(shape, origin, direction);
    std::vector<double> result;
    if (line.low > line.high) return result;
    for (const T t : method.roots(line.f, line.low, line.high))
        result.push_back(line.shift + line.scale * static_cast<double>(t));
    return result;
}

}  // namespace sightline
