#pragma once
// Ray against triangle as published, each method over any scalar T. The watertight ones are in
// watertight.h. A method is constructed from a ray, so that per-ray values are computed once, and
// is then called with triangles that its `prepare` has preprocessed. It intersects the whole line:
// the caller compares t with the segment.
#include "core/math.h"
#include "intersect/methods/planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

namespace sightline {

template <class T>
struct TriangleHit {
    T t, u, v;  ///< barycentrics of the second and third vertex
};

/// The three vertices.
template <class T>
struct Corners {
    Imath::Vec3<T> a, b, c;
};

/// As in the lecture: the plane first, then three same-side tests on the point of intersection.
template <class T>
class PlaneInside {
  public:
    static constexpr std::string_view name = "plane-inside";
    static constexpr std::string_view description = "plane, then three same-side tests";
    using V = Imath::Vec3<T>;
    struct Triangle {
        Corners<T> corners;
        V normal;
        T normal2;
    };

    static Triangle prepare(const Corners<T>& p) {
        const V normal = cross(p.b - p.a, p.c - p.a);
        return {p, normal, dot(normal, normal)};
    }
    PlaneInside(const V& origin, const V& direction) : origin_(origin), direction_(direction) {}

    std::optional<TriangleHit<T>> operator()(const Triangle& triangle) const {
        const auto& [a, b, c] = triangle.corners;
        const auto t = plane_t(origin_, direction_, a, triangle.normal);
        if (!t) return std::nullopt;
        const V p = origin_ + direction_ * *t;
        const T w = dot(cross(c - b, p - b), triangle.normal);
        const T u = dot(cross(a - c, p - c), triangle.normal);
        const T v = dot(cross(b - a, p - a), triangle.normal);
        if (w < T(0) || u < T(0) || v < T(0)) return std::nullopt;
        return TriangleHit<T>{*t, u / triangle.normal2, v / triangle.normal2};
    }

  private:
    V origin_, direction_;
};

/// Snyder and Barr, Ray Tracing Complex Models Containing Surface Tessellations, SIGGRAPH 1987;
/// Badouel, Graphics Gems 1990: the plane, then barycentrics in the projection along the normal's
/// largest component.
template <class T>
class SnyderBarr {
  public:
    static constexpr std::string_view name = "snyder-barr";
    static constexpr std::string_view description =
        "Snyder and Barr 1987: plane, then projected barycentrics";
    using V = Imath::Vec3<T>;
    struct Triangle {
        Corners<T> corners;
        V normal;
        int i, j;  ///< the axes of the projection
    };

    static Triangle prepare(const Corners<T>& p) {
        const V n = cross(p.b - p.a, p.c - p.a);
        const T x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
        const int k = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
        return {p, n, (k + 1) % 3, (k + 2) % 3};
    }
    SnyderBarr(const V& origin, const V& direction) : origin_(origin), direction_(direction) {}

    std::optional<TriangleHit<T>> operator()(const Triangle& triangle) const {
        const auto& [a, b, c] = triangle.corners;
        const int i = triangle.i, j = triangle.j;
        const auto t = plane_t(origin_, direction_, a, triangle.normal);
        if (!t) return std::nullopt;
        const T px = origin_[i] + direction_[i] * *t - a[i];
        const T py = origin_[j] + direction_[j] * *t - a[j];
        const T bi = b[i] - a[i], bj = b[j] - a[j], ci = c[i] - a[i], cj = c[j] - a[j];
        const T area = bi * cj - bj * ci;
        const T u = (px * cj - py * ci) / area, v = (bi * py - bj * px) / area;
        if (!(u >= T(0) && v >= T(0) && u + v <= T(1))) return std::nullopt;
        return TriangleHit<T>{*t, u, v};
    }

  private:
    V origin_, direction_;
};

/// Möller and Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, JGT 2(1) 1997, with
/// stored edges and no epsilon: 1 division, 27 multiplications, 17 additions to t, u and v.
template <class T>
class MollerTrumbore {
  public:
    static constexpr std::string_view name = "moller-trumbore";
    static constexpr std::string_view description = "Möller and Trumbore 1997";
    using V = Imath::Vec3<T>;
    struct Triangle {
        V a, ab, ac;
    };

    static Triangle prepare(const Corners<T>& p) { return {p.a, p.b - p.a, p.c - p.a}; }
    MollerTrumbore(const V& origin, const V& direction) : origin_(origin), direction_(direction) {}

    std::optional<TriangleHit<T>> operator()(const Triangle& triangle) const {
        const V p = cross(direction_, triangle.ac);
        const T determinant = dot(triangle.ab, p);
        if (determinant == T(0)) return std::nullopt;
        const T inverse = T(1) / determinant;
        const V s = origin_ - triangle.a;
        const T u = dot(s, p) * inverse;
        if (u < T(0) || u > T(1)) return std::nullopt;
        const V q = cross(s, triangle.ab);
        const T v = dot(direction_, q) * inverse;
        if (v < T(0) || u + v > T(1)) return std::nullopt;
        return TriangleHit<T>{dot(triangle.ac, q) * inverse, u, v};
    }

  private:
    V origin_, direction_;
};

/// Baldwin and Weber, Fast Ray-Triangle Intersections by Coordinate Transformation, JCGT 5(3)
/// 2016: a stored map transforms the triangle to the unit triangle; the free axis is the normal's
/// largest.
template <class T>
class BaldwinWeber {
  public:
    static constexpr std::string_view name = "baldwin-weber";
    static constexpr std::string_view description = "Baldwin and Weber 2016: a stored affine map";
    using V = Imath::Vec3<T>;
    struct Triangle {
        V u, v, w;  ///< rows of the map; w is the height above the plane
        T u0, v0, w0;
    };

    static Triangle prepare(const Corners<T>& p) {
        const V ab = p.b - p.a, ac = p.c - p.a, n = cross(ab, ac);
        const T x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
        const int i = x >= y && x >= z ? 0 : y >= z ? 1 : 2, j = (i + 1) % 3, k = (i + 2) % 3;
        Triangle m;
        m.u[i] = m.v[i] = T(0);
        m.w[i] = T(1);
        m.u[j] = ac[k] / n[i], m.u[k] = -ac[j] / n[i];
        m.v[j] = -ab[k] / n[i], m.v[k] = ab[j] / n[i];
        m.w[j] = n[j] / n[i], m.w[k] = n[k] / n[i];
        m.u0 = -dot(m.u, p.a), m.v0 = -dot(m.v, p.a), m.w0 = -dot(m.w, p.a);
        return m;
    }
    BaldwinWeber(const V& origin, const V& direction) : origin_(origin), direction_(direction) {}

    std::optional<TriangleHit<T>> operator()(const Triangle& m) const {
        const T slope = dot(m.w, direction_);
        if (slope == T(0)) return std::nullopt;
        const T t = -(dot(m.w, origin_) + m.w0) / slope;
        const V p = origin_ + direction_ * t;
        const T u = dot(m.u, p) + m.u0, v = dot(m.v, p) + m.v0;
        if (!(u >= T(0) && v >= T(0) && u + v <= T(1))) return std::nullopt;
        return TriangleHit<T>{t, u, v};
    }

  private:
    V origin_, direction_;
};

/// Plücker coordinates as in Embree's robust mode
/// (kernels/geometry/triangle_intersector_pluecker.h): three edge functions, accepted within one
/// ulp of their sum.
template <class T>
class Plucker {
  public:
    static constexpr std::string_view name = "plucker";
    static constexpr std::string_view description =
        "Plücker coordinates as in Embree's ROBUST mode";
    using V = Imath::Vec3<T>;
    using Triangle = Corners<T>;

    static Triangle prepare(const Corners<T>& p) { return p; }
    Plucker(const V& origin, const V& direction) : origin_(origin), direction_(direction) {}

    std::optional<TriangleHit<T>> operator()(const Triangle& p) const {
        const V a = p.a - origin_, b = p.b - origin_, c = p.c - origin_;
        const V ca = c - a, ab = a - b, bc = b - c;
        const T u = dot(cross(ca, c + a), direction_), v = dot(cross(ab, a + b), direction_),
                w = dot(cross(bc, b + c), direction_), sum = u + v + w;
        const T slack = std::numeric_limits<T>::epsilon() * std::abs(sum);
        if (std::min({u, v, w}) < -slack && std::max({u, v, w}) > slack) return std::nullopt;
        const V normal = stable_normal(ca, ab, bc);
        const T slope = T(2) * dot(normal, direction_);
        if (slope == T(0)) return std::nullopt;
        return TriangleHit<T>{T(2) * dot(a, normal) / slope, u / sum, v / sum};
    }

  private:
    /// Each component from the pair of edges whose products cancel less.
    static V stable_normal(const V& ca, const V& ab, const V& bc) {
        const V first = cross(ab, ca), second = cross(bc, ab);
        V normal;
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            normal[i] = std::abs(ab[k] * ca[j]) < std::abs(bc[k] * ab[j]) ? first[i] : second[i];
        }
        return normal;
    }

    V origin_, direction_;
};

}  // namespace sightline
