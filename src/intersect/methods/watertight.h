#pragma once
// Ray against triangle without gaps between neighbours. See triangles.h for the conventions.
#include "exact/triangle.h"
#include "intersect/methods/triangles.h"

#include <algorithm>
#include <type_traits>

namespace sightline {

/// a·b − c·d in the next wider type, if there is one.
template <class T>
auto widened_edge(T a, T b, T c, T d) {
    using Wide = std::conditional_t<std::is_same_v<T, float>, double, long double>;
    return static_cast<Wide>(a) * static_cast<Wide>(b) -
           static_cast<Wide>(c) * static_cast<Wide>(d);
}

/// a·b − c·d, each product exact but for its last bit (Kahan; Jeannerod, Louvet and Muller 2013).
template <class T>
T difference_of_products(T a, T b, T c, T d) {
    const T cd = c * d;
    return std::fma(a, b, -cd) + std::fma(-c, d, cd);
}

/// How Woop's test computes an edge function in the sheared plane.
enum class WoopEdges {
    plain,    ///< in T, and all three again in wider numbers if one is zero
    products  ///< by difference of products, as pbrt-v4
};

/// Woop, Benthin and Wald, Watertight Ray/Triangle Intersection, JCGT 2(1) 2013: the ray becomes
/// the z axis by a shear; signs of two-dimensional edge functions decide.
template <class T, WoopEdges edges = WoopEdges::plain>
class Woop {
  public:
    static constexpr std::string_view name = edges == WoopEdges::plain ? "woop" : "woop-products";
    static constexpr std::string_view description =
        edges == WoopEdges::plain ? "Woop, Benthin and Wald 2013"
                                  : "Woop, Benthin and Wald 2013 with compensated products";
    using V = Imath::Vec3<T>;
    using Triangle = Corners<T>;

    static Triangle prepare(const Corners<T>& p) { return p; }
    Woop(const V& origin, const V& direction) : origin_(origin) {
        const T x = std::abs(direction.x), y = std::abs(direction.y), z = std::abs(direction.z);
        z_ = x > y && x > z ? 0 : y > z ? 1 : 2;
        x_ = (z_ + 1) % 3;
        y_ = (x_ + 1) % 3;
        if (direction[z_] < T(0)) std::swap(x_, y_);
        shear_ = {direction[x_] / direction[z_], direction[y_] / direction[z_],
                  T(1) / direction[z_]};
    }

    std::optional<TriangleHit<T>> operator()(const Triangle& p) const {
        const V a = sheared(p.a), b = sheared(p.b), c = sheared(p.c);
        const auto [u, v, w] = edge_functions(a, b, c);
        if ((u < T(0) || v < T(0) || w < T(0)) && (u > T(0) || v > T(0) || w > T(0)))
            return std::nullopt;
        const T determinant = u + v + w;
        if (determinant == T(0)) return std::nullopt;
        const T t = (w * a.z + u * b.z + v * c.z) * shear_.z;
        return TriangleHit<T>{t / determinant, u / determinant, v / determinant};
    }

  private:
    V sheared(const V& vertex) const {
        const V p = vertex - origin_;
        return {p[x_] - shear_.x * p[z_], p[y_] - shear_.y * p[z_], p[z_]};
    }

    /// Twice the areas opposite b, c and a.
    static std::array<T, 3> edge_functions(const V& a, const V& b, const V& c) {
        if constexpr (edges == WoopEdges::products)
            return {difference_of_products(a.x, c.y, a.y, c.x),
                    difference_of_products(b.x, a.y, b.y, a.x),
                    difference_of_products(c.x, b.y, c.y, b.x)};
        const std::array<T, 3> plain = {a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x,
                                        c.x * b.y - c.y * b.x};
        if (plain[0] != T(0) && plain[1] != T(0) && plain[2] != T(0)) return plain;
        return {static_cast<T>(widened_edge(a.x, c.y, a.y, c.x)),
                static_cast<T>(widened_edge(b.x, a.y, b.y, a.x)),
                static_cast<T>(widened_edge(c.x, b.y, c.y, b.x))};
    }

    V origin_, shear_;
    int x_, y_, z_;
};

template <class T>
using WoopProducts = Woop<T, WoopEdges::products>;

/// Edge functions in T with a bound of their error; exact arithmetic decides doubtful signs, so
/// that no decision is ever wrong. Inputs are floats for every T. (After Shewchuk, Adaptive
/// Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates, DCG 18, 1997.)
template <class T>
class ExactFiltered {
  public:
    static constexpr std::string_view name = "exact-filtered";
    static constexpr std::string_view description =
        "edge functions with an error bound, exact arithmetic when in doubt";
    using V = Imath::Vec3<T>;
    using Triangle = Corners<T>;

    static Triangle prepare(const Corners<T>& p) { return p; }
    ExactFiltered(const V& origin, const V& direction) : origin_(origin), direction_(direction) {}

    std::optional<TriangleHit<T>> operator()(const Triangle& p) const {
        const V ab = p.b - p.a, ac = p.c - p.a, s = p.a - origin_, normal = cross(ab, ac);
        const V r = cross(s, direction_);
        const T determinant = dot(normal, direction_), u = dot(r, ac), v = -dot(r, ab),
                w = determinant - u - v;
        const T error = error_bound(s, ab, ac);
        const T least = std::min({u, v, w}), most = std::max({u, v, w});
        const bool finite = std::isfinite(u + v + w) && std::isfinite(error);
        if (finite && least < -error && most > error) return std::nullopt;
        if (!finite || (least <= error && most >= -error)) return exactly(p);
        const T distance = dot(s, normal);
        const bool sound = std::isfinite(distance) && std::abs(distance) > underflow(s, ab, ac);
        if (!sound) return exactly(p);
        return TriangleHit<T>{distance / determinant, u / determinant, v / determinant};
    }

  private:
    static T sum_of_magnitudes(const V& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

    /// The error by products below the normal numbers.
    T underflow(const V& s, const V& ab, const V& ac) const {
        const T lengths = sum_of_magnitudes(s) + sum_of_magnitudes(ab) + sum_of_magnitudes(ac);
        return 8 * std::numeric_limits<T>::min() * (1 + sum_of_magnitudes(direction_) + lengths);
    }

    /// The error of u, v and w. Each rounding contributes at most one unit of the largest term;
    /// there are fewer than 32 of them (counted as in Higham's lemma 3.1, with a margin).
    T error_bound(const V& s, const V& ab, const V& ac) const {
        const T edge = std::max(sum_of_magnitudes(ab), sum_of_magnitudes(ac));
        const T distance = sum_of_magnitudes(s) + edge;
        return 32 * std::numeric_limits<T>::epsilon() * sum_of_magnitudes(direction_) * edge *
                   distance +
               underflow(s, ab, ac);
    }

    std::optional<TriangleHit<T>> exactly(const Triangle& p) const {
        constexpr float no_limit = std::numeric_limits<float>::infinity();
        const Ray ray = {Vec3(origin_), -std::numeric_limits<float>::max(), Vec3(direction_),
                         no_limit};
        const InstancedTriangle triangle = {Vec3(p.a), Vec3(p.b), Vec3(p.c), nullptr};
        if (exact_crossing(ray, triangle) != Crossing::hit) return std::nullopt;
        const ExactHit hit = exact_hit(ray, triangle);
        return TriangleHit<T>{static_cast<T>(hit.t), static_cast<T>(hit.u), static_cast<T>(hit.v)};
    }

    V origin_, direction_;
};

}  // namespace sightline
