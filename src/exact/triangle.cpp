#include "exact/triangle.h"

#include "exact/triangle_form.h"

#include <algorithm>
#include <cassert>
#include <optional>

namespace sightline {
namespace {

using Sign = std::optional<int>;

Sign sign_of(const Bounded& x) { return x.sign(); }
Sign sign_of(const Dyadic& x) { return x.sign(); }

/// The common sign of u, v and w if the line hits the closed triangle; 0 if it misses.
struct LineVerdict {
    bool edge_on = false;
    int orientation = 0;
};

/// Returns nullopt if the arithmetic cannot decide.
template <class T>
std::optional<LineVerdict> line_verdict(const TriangleForm<T>& form) {
    const Sign signs[] = {sign_of(form.u), sign_of(form.v), sign_of(form.w)};
    bool negative = false, positive = false, unknown = false;
    for (const Sign& sign : signs) {
        negative |= sign == -1;
        positive |= sign == 1;
        unknown |= !sign;
    }
    if (negative && positive) return LineVerdict{};
    if (unknown) return std::nullopt;
    if (!negative && !positive) return LineVerdict{true, 0};
    return LineVerdict{false, positive ? 1 : -1};
}

template <class T>
std::optional<Crossing> crossing(const TriangleForm<T>& form, float tnear, float tfar) {
    const auto line = line_verdict(form);
    if (!line) return std::nullopt;
    if (line->edge_on) return Crossing::edge_on;
    if (line->orientation == 0) return Crossing::miss;
    const T determinant = form.determinant();
    const Sign past_near = sign_of(form.distance - from_float<T>(tnear) * determinant);
    const Sign past_far = std::isinf(tfar)
                              ? Sign(-line->orientation)
                              : sign_of(form.distance - from_float<T>(tfar) * determinant);
    if (past_near && *past_near * line->orientation <= 0) return Crossing::miss;
    if (past_far && *past_far * line->orientation > 0) return Crossing::miss;
    if (!past_near || !past_far) return std::nullopt;
    return Crossing::hit;
}

double norm1(const Vec3d& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

/// What plain doubles can tell about a triangle in world space, with one bound for all errors: of a
/// ray that leaves a triangle, that it does not hit it again.
///
/// A product v · (p × e) of differences of floats is a sum of six terms, whose magnitudes add up to
/// at most |v|∞ |p|₁ |e|₁; each is off by less than 8 units of rounding (2⁻⁵³), of which 16 are
/// allowed. Products of three floats neither overflow nor underflow in double.
std::optional<Crossing> quick_crossing(const Ray& ray, const InstancedTriangle& triangle) {
    if (triangle.to_world != nullptr) return std::nullopt;
    constexpr double units = 0x1p-49;
    const Vec3d o = from_floats<double>(ray.origin), d = from_floats<double>(ray.direction),
                p = from_floats<double>(triangle.a), q = from_floats<double>(triangle.b),
                r = from_floats<double>(triangle.c);
    const Vec3d a = p - o, b = q - o, c = r - o, pq = q - p, qr = r - q, rp = p - r;
    const double u = dot(d, cross(c, rp)), v = dot(d, cross(a, pq)), w = dot(d, cross(b, qr));
    const double largest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    const double error = units * largest * std::max({norm1(a), norm1(b), norm1(c)}) *
                         std::max({norm1(pq), norm1(qr), norm1(rp)});
    const double least = std::min({u, v, w}), most = std::max({u, v, w});
    if (least < -error && most > error) return Crossing::miss;
    const double determinant = u + v + w;
    if (!(std::abs(determinant) > 4 * error)) return std::nullopt;
    const double distance = dot(a, cross(rp, pq));
    const double distance_error = units * norm1(a) * norm1(pq) * norm1(rp);
    // 1 or −1 if the plane surely lies beyond or before that t, otherwise 0.
    const auto side = [&](float end) {
        const double t = exact_double(end), difference = distance - t * determinant;
        const double bound = 2 * (distance_error + std::abs(t) * 8 * error);
        const int sign = difference > bound ? 1 : difference < -bound ? -1 : 0;
        return determinant > 0 ? sign : -sign;
    };
    const int near = side(ray.tnear), far = std::isinf(ray.tfar) ? -1 : side(ray.tfar);
    if (near < 0 || far > 0) return Crossing::miss;
    const bool inside = least > error || most < -error;
    return inside && near > 0 && far < 0 ? std::optional(Crossing::hit) : std::nullopt;
}

ExactHit rounded_hit(const TriangleForm<Dyadic>& form, const std::array<Vec3e, 3>& vertices) {
    const Dyadic determinant = form.determinant();
    const auto& [a, b, c] = vertices;
    const Vec3e normal = cross(b - a, c - a);
    const Dyadic length2 = dot(normal, normal);
    return {rounded_quotient(form.distance, determinant),
            rounded_quotient(form.u, determinant),
            rounded_quotient(form.v, determinant),
            {rounded_cosine(normal.x, length2), rounded_cosine(normal.y, length2),
             rounded_cosine(normal.z, length2)}};
}

/// The distance and the determinant of TriangleForm, without its edge functions.
struct ExactPlane {
    Dyadic distance;

    ExactPlane(const Ray& ray, const InstancedTriangle& triangle) {
        const auto [a, b, c] = world_vertices<Dyadic>(triangle);
        const Vec3e normal = cross(b - a, c - a);
        distance = dot(a - exact_vector(ray.origin), normal);
        determinant_ = dot(exact_vector(ray.direction), normal);
    }
    const Dyadic& determinant() const { return determinant_; }

  private:
    Dyadic determinant_;
};

/// Of two planes, as TriangleForm or ExactPlane.
template <class Plane>
Sign order(const Plane& first, const Plane& second) {
    const auto p = first.determinant(), q = second.determinant();
    const Sign difference = sign_of(first.distance * q - second.distance * p);
    const Sign sp = sign_of(p), sq = sign_of(q);
    if (!difference || !sp || !sq) return std::nullopt;
    return *difference * *sp * *sq;
}

/// The fifteen floats that the result depends on.
std::array<float*, 15> coordinates(Ray& ray, InstancedTriangle& triangle) {
    std::array<float*, 15> result;
    Vec3* vectors[] = {&ray.origin, &ray.direction, &triangle.a, &triangle.b, &triangle.c};
    for (size_t i = 0; i < result.size(); ++i)
        result[i] = &(*vectors[i / 3])[static_cast<int>(i % 3)];
    return result;
}

/// The interval of one ulp around `value`.
Bounded with_one_ulp(float value) {
    const double up = exact_double(std::nextafter(value, INFINITY));
    const double down = exact_double(std::nextafter(value, -INFINITY));
    const double middle = exact_double(value);
    return {middle, std::max(up - middle, middle - down)};
}

Imath::Vec3<Bounded> with_one_ulp(const Vec3& v) {
    return {with_one_ulp(v.x), with_one_ulp(v.y), with_one_ulp(v.z)};
}

bool certain_within_one_ulp(const Ray& ray, const InstancedTriangle& triangle) {
    if (triangle.to_world != nullptr) return false;
    const TriangleForm<Bounded> form(
        with_one_ulp(ray.origin), with_one_ulp(ray.direction),
        {with_one_ulp(triangle.a), with_one_ulp(triangle.b), with_one_ulp(triangle.c)});
    return crossing(form, ray.tnear, ray.tfar).has_value();
}

}  // namespace

Crossing exact_crossing(const Ray& ray, const InstancedTriangle& triangle) {
    assert(has_exact_answer(ray));
    if (const auto known = quick_crossing(ray, triangle)) return *known;
    const TriangleForm<Bounded> filter(ray, triangle);
    if (const auto known = crossing(filter, ray.tnear, ray.tfar)) return *known;
    return *crossing(TriangleForm<Dyadic>(ray, triangle), ray.tnear, ray.tfar);
}

ExactHit exact_hit(const Ray& ray, const InstancedTriangle& triangle) {
    return rounded_hit(TriangleForm<Dyadic>(ray, triangle), world_vertices<Dyadic>(triangle));
}

double exact_t(const Ray& ray, const InstancedTriangle& triangle) {
    const ExactPlane plane(ray, triangle);
    return rounded_quotient(plane.distance, plane.determinant());
}

namespace {

/// A vector in double, and the 1-norm of the numbers whose sum it is: its error is a few 2^-53 of
/// that.
struct Sum {
    Vec3d value;
    double size;
};

Sum difference(const Vec3& a, const Vec3& b) {
    const Vec3d v = Vec3d(a) - Vec3d(b);
    return {v, std::abs(v.x) + std::abs(v.y) + std::abs(v.z)};
}

/// v · matrix, without the translation.
Sum turned(const Sum& v, const Mat4* matrix) {
    if (matrix == nullptr) return v;
    Sum result{Vec3d(0, 0, 0), 0};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const double term = v.value[i] * static_cast<double>((*matrix)[i][j]);
            result.value[j] += term;
            result.size += std::abs(term);
        }
    return result;
}

/// The vertex a as seen from the ray's origin.
Sum from_origin(const Ray& ray, const InstancedTriangle& triangle) {
    const Mat4* m = triangle.to_world;
    if (m == nullptr) return difference(triangle.a, ray.origin);
    const Sum place = difference({(*m)[3][0], (*m)[3][1], (*m)[3][2]}, ray.origin);
    const Sum a = turned({Vec3d(triangle.a), 0}, m);
    return {a.value + place.value, a.size + place.size};
}

}  // namespace

PlaneHit plane_hit(const Ray& ray, const InstancedTriangle& triangle) {
    const Vec3d d(ray.direction);
    const double length = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
    // Edges are transformed as such: the difference of transformed vertices would lose digits.
    const Sum ab = turned(difference(triangle.b, triangle.a), triangle.to_world),
              ac = turned(difference(triangle.c, triangle.a), triangle.to_world),
              s = from_origin(ray, triangle);
    const Vec3d normal = cross(ab.value, ac.value);
    const double determinant = dot(normal, d), distance = dot(s.value, normal);
    const double edges = ab.size * ac.size;
    if (std::abs(determinant) > 0x1p-20 * edges * length &&
        std::abs(distance) > 0x1p-20 * edges * s.size) {
        const Vec3d r = cross(s.value, d);
        const double inverse = 1 / determinant;
        return {distance * inverse, dot(r, ac.value) * inverse, -dot(r, ab.value) * inverse};
    }
    const TriangleForm<Dyadic> form(ray, triangle);
    const Dyadic exact = form.determinant();
    return {rounded_quotient(form.distance, exact), rounded_quotient(form.u, exact),
            rounded_quotient(form.v, exact)};
}

int compare_exactly(const Ray& ray, const InstancedTriangle& first,
                    const InstancedTriangle& second) {
    const Sign known = order(TriangleForm<Bounded>(ray, first), TriangleForm<Bounded>(ray, second));
    if (known) return *known;
    return *order(ExactPlane(ray, first), ExactPlane(ray, second));
}

Enclosure enclose_t(const Ray& ray, const InstancedTriangle& triangle) {
    const TriangleForm<Bounded> form(ray, triangle);
    const Bounded p = form.distance, q = form.determinant();
    const double least = std::abs(q.value) - q.error;
    if (least > 0) {
        const double t = p.value / q.value;
        const double error =
            ((p.error + std::abs(t) * q.error) / least + std::abs(t) * 0x1p-52) * (1 + 0x1p-40);
        if (error <= std::abs(t) * 0x1p-16) return {t - error, t + error};
    }
    const double t = exact_t(ray, triangle);
    return {std::nextafter(t, -INFINITY), std::nextafter(t, INFINITY)};
}

std::array<Ray, 12> neighbours_of(const Ray& ray, float origin_size, float direction_size) {
    std::array<Ray, 12> neighbours;
    auto next = neighbours.begin();
    for (const auto& [part, size] :
         {std::pair(&Ray::origin, origin_size), std::pair(&Ray::direction, direction_size)})
        for (int axis = 0; axis < 3; ++axis)
            for (const float end : {-INFINITY, INFINITY}) {
                *next = ray;
                float& coordinate = ((*next++).*part)[axis];
                const bool own = std::abs(coordinate) >= size;
                const float ulp = std::nextafter(size, INFINITY) - size;
                coordinate =
                    own ? std::nextafter(coordinate, end) : coordinate + std::copysign(ulp, end);
            }
    return neighbours;
}

bool decidable_at_float(const Ray& ray, const InstancedTriangle& triangle) {
    if (certain_within_one_ulp(ray, triangle)) return true;
    const Crossing verdict = exact_crossing(ray, triangle);
    Ray moved_ray = ray;
    InstancedTriangle moved = triangle;
    for (float* coordinate : coordinates(moved_ray, moved)) {
        const float value = *coordinate;
        for (const float end : {-INFINITY, INFINITY}) {
            *coordinate = std::nextafter(value, end);
            const bool valid = std::isfinite(*coordinate) && has_exact_answer(moved_ray);
            if (valid && exact_crossing(moved_ray, moved) != verdict) return false;
        }
        *coordinate = value;
    }
    return true;
}

Box3 exact_bounds(const InstancedTriangle& triangle) {
    Box3 box;
    for (const auto& vertex : world_vertices<Bounded>(triangle))
        for (int i = 0; i < 3; ++i) {
            const Bounded& x = vertex[i];
            box.min[i] = std::min(box.min[i], float_below(x.value - 2 * x.error));
            box.max[i] = std::max(box.max[i], float_above(x.value + 2 * x.error));
        }
    return box;
}

struct NestedTriangle::Vertices {
    std::array<Vec3e, 3> exact;
    std::array<Vec3d, 3> rounded;

    TriangleForm<Dyadic> form(const Ray& ray) const {
        return {exact_vector(ray.origin), exact_vector(ray.direction), exact};
    }
    TriangleForm<Bounded> filter(const Ray& ray) const {
        const auto near = [](double x) { return Bounded(x, std::abs(x) * 0x1p-53 + 0x1p-1074); };
        std::array<Imath::Vec3<Bounded>, 3> bounded;
        for (size_t i = 0; i < 3; ++i)
            bounded[i] = {near(rounded[i].x), near(rounded[i].y), near(rounded[i].z)};
        return {from_floats<Bounded>(ray.origin), from_floats<Bounded>(ray.direction), bounded};
    }
};

NestedTriangle::NestedTriangle(const std::array<Vec3, 3>& corners, std::span<const Mat4> nodes) {
    Vertices result;
    for (size_t i = 0; i < 3; ++i) {
        Vec3e p = exact_vector(corners[i]);
        for (const Mat4& m : nodes) p = moved(p, m);
        result.exact[i] = p;
        for (int axis = 0; axis < 3; ++axis)
            result.rounded[i][axis] = rounded_quotient(p[axis], Dyadic(1.0));
    }
    vertices_ = std::make_shared<const Vertices>(std::move(result));
}

Crossing NestedTriangle::crossing(const Ray& ray) const {
    if (const auto known = sightline::crossing(vertices_->filter(ray), ray.tnear, ray.tfar))
        return *known;
    return *sightline::crossing(vertices_->form(ray), ray.tnear, ray.tfar);
}

ExactHit NestedTriangle::hit(const Ray& ray) const {
    return rounded_hit(vertices_->form(ray), vertices_->exact);
}

std::array<Vec3d, 3> NestedTriangle::corners() const { return vertices_->rounded; }

}  // namespace sightline
