// A second judge of rays and analytic shapes, written from docs/truth.md and docs/shapes.md. It
// shares no code with src/exact: rational.h finds the roots, matrices are inverted by Cramer's rule
// over rational numbers, a ray that keeps away from a ball around a shape misses it, solids are
// convex bodies whose boundary the ray crosses, a capsule is the least of a family of balls, and
// every surface is tested. SIGHTLINE_SECOND_OPINION_RAYS sets the number of rays.
#include "core/parallel.h"
#include "exact/rational.h"
#include "exact/referee.h"
#include "support/scenes.h"

#include <gtest/gtest.h>

#include <atomic>
#include <random>

namespace sightline {
namespace {

using rational::Number;
using rational::number;
using rational::Point;
using rational::Polynomial;
using rational::Root;

/// p · m for the linear part and the translation of a matrix of rational numbers.
struct Map {
    std::array<Point, 4> rows;

    template <class Matrix>
    explicit Map(const Matrix& m) {
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 3; ++j)
                rows[static_cast<size_t>(i)][static_cast<size_t>(j)] = number(m[i][j]);
    }

    Point turned(const Point& p) const {
        Point result;
        for (size_t j = 0; j < 3; ++j)
            result[j] = p[0] * rows[0][j] + p[1] * rows[1][j] + p[2] * rows[2][j];
        return result;
    }

    Map() = default;

    /// The inverse, by Cramer's rule.
    Map inverse() const {
        Map result;
        for (size_t i = 0; i < 3; ++i) {
            Point unit;
            unit[i] = 1;
            result.rows[i] = solved(unit);
        }
        const Point moved = result.turned(rows[3]);
        result.rows[3] = {-moved[0], -moved[1], -moved[2]};
        return result;
    }

    /// This map, then the other.
    Map then(const Map& other) const {
        Map result;
        for (size_t i = 0; i < 4; ++i) result.rows[i] = other.turned(rows[i]);
        for (size_t j = 0; j < 3; ++j) result.rows[3][j] += other.rows[3][j];
        return result;
    }

  private:
    /// The q with q · linear part = p.
    Point solved(const Point& p) const {
        const auto determinant = [](const Point& a, const Point& b, const Point& c) {
            return Number(a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                          a[2] * (b[0] * c[1] - b[1] * c[0]));
        };
        const Number whole = determinant(rows[0], rows[1], rows[2]);
        return {determinant(p, rows[1], rows[2]) / whole, determinant(rows[0], p, rows[2]) / whole,
                determinant(rows[0], rows[1], p) / whole};
    }
};

/// A shape with its place in the world.
struct Body {
    SurfaceId id;
    const Shape* shape;
    Map from_world;               // to the space of the shape
    std::optional<Number> reach;  // the square of a distance from the origin that no point exceeds
};

/// Body::reach; none for an endless plane.
std::optional<Number> reach_of(const Shape& shape) {
    const auto squared = [](const Number& x) { return Number(x * x); };
    const Number top = number(shape.radius_top), bottom = number(shape.radius_bottom),
                 wider = std::max(top, bottom), half = number(shape.height) / 2;
    const Number x = number(shape.size.x) / 2, y = number(shape.size.y) / 2,
                 z = number(shape.size.z) / 2;
    switch (shape.kind) {
        case ShapeKind::sphere:
            return squared(number(shape.radius));
        case ShapeKind::torus:
            return squared(number(shape.radius) + number(shape.tube_radius));
        case ShapeKind::heart:  // beyond it, the cube exceeds the terms of fifth order
            return squared(3 * number(shape.scale));
        case ShapeKind::plane:
            if (x == 0 || z == 0) return {};
            return squared(x) + squared(z);
        case ShapeKind::box:
            return squared(x) + squared(y) + squared(z);
        case ShapeKind::cylinder:
            return squared(half) + squared(wider);
        case ShapeKind::capsule:
            return squared(half + wider);
    }
    return {};
}

/// The points o + t d of a ray in the space of a shape.
struct Line {
    Point o, d;

    Line(const Point& origin, const Point& direction, const Body& body)
        : o(body.from_world.turned(origin)), d(body.from_world.turned(direction)) {
        for (size_t i = 0; i < 3; ++i) o[i] += body.from_world.rows[3][i];
    }

    /// Whether all its points with t ≥ 0 are farther from the origin than √reach.
    bool keeps_away(const Number& reach) const {
        const auto dot = [](const Point& a, const Point& b) {
            return Number(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
        };
        const Number outside = dot(o, o) - reach;
        if (outside <= 0) return false;
        const Number along = dot(o, d);
        return along >= 0 || along * along < outside * dot(d, d);
    }
};

/// Finds where a ray crosses or touches a shape.
class Crossings {
  public:
    Crossings(const Ray& ray, const Body& body, const Line& line) : ray_(ray), shape_(*body.shape) {
        for (size_t i = 0; i < 3; ++i)
            point_[i] = Polynomial(std::vector<Number>{line.o[i], line.d[i]});
        const auto& [x, y, z] = point_;
        x2_ = x * x;
        y2_ = y * y;
        z2_ = z * z;
    }

    std::vector<Root> find() {
        switch (shape_.kind) {
            case ShapeKind::sphere:
                add(x2_ + y2_ + z2_ - squared(shape_.radius));
                break;
            case ShapeKind::torus:
                torus();
                break;
            case ShapeKind::heart:
                heart();
                break;
            case ShapeKind::plane:
                add(point_[1], slabs(shape_.size.x > 0, false, shape_.size.z > 0));
                break;
            case ShapeKind::box:
                box();
                break;
            case ShapeKind::cylinder:
                cylinder();
                break;
            case ShapeKind::capsule:
                capsule();
        }
        return std::move(found_);
    }

  private:
    using Polynomials = std::vector<Polynomial>;

    static Number squared(float x) { return number(x) * number(x); }

    /// Adds the roots of an equation at which none of the functions is positive.
    void add(const Polynomial& equation, const Polynomials& not_positive = {}) {
        for (Root& root : rational::roots_of(equation, ray_))
            if (std::ranges::all_of(not_positive,
                                    [&](const Polynomial& f) { return root.sign_of(f) <= 0; }))
                found_.push_back(root);
    }

    /// Functions that are positive outside the extents along the chosen axes.
    Polynomials slabs(bool x, bool y, bool z) const {
        const bool chosen[] = {x, y, z};
        Polynomials outside;
        for (size_t i = 0; i < 3; ++i) {
            const Number half = number(shape_.size[static_cast<int>(i)]) / 2;
            if (chosen[i]) outside.push_back(point_[i] * point_[i] - Polynomial(half * half));
        }
        return outside;
    }

    void torus() {
        // ((√(x² + z²) − R)² + y² − r²) · ((√(x² + z²) + R)² + y² − r²)
        const Polynomial sum = x2_ + y2_ + z2_ + Polynomial(squared(shape_.radius)) -
                               Polynomial(squared(shape_.tube_radius));
        add(sum * sum - Polynomial(4 * squared(shape_.radius)) * (x2_ + z2_));
    }

    void heart() {
        // in the units of scale 1
        const Polynomial inverse(1 / number(shape_.scale));
        const Polynomial x = point_[0] * inverse, y = point_[1] * inverse, z = point_[2] * inverse;
        const Polynomial a =
            x * x + Polynomial(Number(9, 4)) * z * z + y * y - Polynomial(Number(1));
        add(a * a * a - x * x * y * y * y - Polynomial(Number(9, 80)) * z * z * y * y * y);
    }

    void box() {
        const Polynomials outside = slabs(true, true, true);
        for (const Polynomial& face : outside) add(face, outside);
    }

    void cylinder() {
        const Number half = number(shape_.height) / 2;
        const Polynomial radius =
            Polynomial((number(shape_.radius_top) + number(shape_.radius_bottom)) / 2) +
            Polynomial((number(shape_.radius_top) - number(shape_.radius_bottom)) /
                       number(shape_.height)) *
                point_[1];
        const Polynomials outside = {y2_ - Polynomial(half * half), x2_ + z2_ - radius * radius};
        for (const Polynomial& part : outside) add(part, outside);
    }

    /// Within the hull, a point lies in a ball of centre −h/2 + s·h and radius b + s·(a − b) for
    /// an s in [0, 1]: |p − centre|² − radius² = A s² + B s + C is ≤ 0. On the surface, its least
    /// value is 0.
    void capsule() {
        const Number h = number(shape_.height), b = number(shape_.radius_bottom),
                     slope = number(shape_.radius_top) - b;
        const Polynomial rise = point_[1] + Polynomial(h / 2);
        const Number a = h * h - slope * slope;
        const Polynomial linear =
            Polynomial(Number(-2)) * (Polynomial(h) * rise + Polynomial(b * slope));
        const Polynomial bottom = x2_ + z2_ + rise * rise - Polynomial(b * b);
        const Polynomial top = Polynomial(a) + linear + bottom;
        const Polynomial zero, minus(Number(-1)), end_slope = Polynomial(2 * a) + linear;
        if (a <= 0) {  // the least value is at an end
            add(bottom, {minus * top});
            add(top, {minus * bottom});
            return;
        }
        add(bottom, {minus * linear});  // it grows from s = 0
        add(top, {end_slope});          // it falls to s = 1
        add(linear * linear - Polynomial(4 * a) * bottom, {linear, minus * end_slope});
    }

    const Ray& ray_;
    const Shape& shape_;
    std::array<Polynomial, 3> point_;
    Polynomial x2_, y2_, z2_;
    std::vector<Root> found_;
};

/// What a ray hits first.
struct ShapeOpinion {
    std::vector<SurfaceId> nearest;
    std::optional<Root> t;
};

ShapeOpinion judge(const Ray& ray, const std::vector<Body>& bodies) {
    ShapeOpinion opinion;
    const Point origin = rational::point(ray.origin), direction = rational::point(ray.direction);
    for (const Body& body : bodies) {
        const Line line(origin, direction, body);
        if (body.reach && line.keeps_away(*body.reach)) continue;
        for (Root& root : Crossings(ray, body, line).find()) {
            const int order = opinion.t ? root.compare(*opinion.t) : -1;
            if (order > 0) continue;
            if (order < 0) opinion.nearest.clear();
            if (order < 0) opinion.t = root;
            // Two parts of a shape meet in an edge.
            if (opinion.nearest.empty() || opinion.nearest.back() != body.id)
                opinion.nearest.push_back(body.id);
        }
    }
    std::ranges::sort(opinion.nearest);
    return opinion;
}

std::vector<Body> bodies_of(const Scene& scene) {
    std::vector<Body> bodies;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        for (const uint32_t shape : scene.groups[instance.group].shapes) {
            Map from_world(scene.shapes[shape].to_shape);
            if (!instance.baked)
                from_world = Map(instance.object_to_world).inverse().then(from_world);
            bodies.push_back({{i, static_cast<uint32_t>(scene.meshes.size()) + shape, 0},
                              &scene.shapes[shape],
                              from_world,
                              reach_of(scene.shapes[shape])});
        }
    }
    return bodies;
}

/// Draws shapes and rays that are difficult for floats.
class ShapeAdversary {
  public:
    explicit ShapeAdversary(unsigned seed) : random_(seed) {}

    /// One shape of each kind in world space, scaled and turned; one of each as instances that are
    /// sheared, mirrored, almost flat and far away, and one a second time at the same place.
    Scene scene() {
        SceneBuilder builder;
        std::vector<Shape> baked;
        for (int kind = 0; kind <= static_cast<int>(ShapeKind::heart); ++kind) {
            baked.push_back(shape(static_cast<ShapeKind>(kind)));
            if (random_() % 2 == 0) baked.back().to_object.setTranslation(Vec3d(lattice()));
            if (random_() % 4 == 0) baked.back().to_object[0][0] = 2;
            if (random_() % 4 == 0) baked.back().to_object[2][1] = 0.1;
            baked.back().to_shape = baked.back().to_object.inverse();
        }
        builder.add_instance(builder.add_group({}, baked));
        std::vector<Mat4> places = this->places();
        for (int kind = 0; kind <= static_cast<int>(ShapeKind::heart); ++kind) {
            const uint32_t group = builder.add_shape(shape(static_cast<ShapeKind>(kind)));
            const Mat4& place = places[random_() % places.size()];
            builder.add_instance(group, place);
            builder.add_instance(group,
                                 random_() % 4 == 0 ? place : places[random_() % places.size()]);
        }
        return builder.finish();
    }

    /// At a point that matters to a shape (a pole, a rim, a corner, a cusp, a tangent), from
    /// another one or from outside; in the space of one of the shapes, taken to the world in
    /// floats.
    Ray ray(const Scene& scene) {
        const Instance& instance = scene.instances[random_() % scene.instances.size()];
        Vec3 from = lattice() * (random_() % 2 == 0 ? 1.0f : 3.0f), to = lattice();
        switch (random_() % 4) {
            case 0:  // along an axis, often tangent
                to = from;
                to[static_cast<int>(random_() % 3)] += 1;
                break;
            case 1:
                to *= 0x1p-10f;  // close to the middle
                break;
            default:
                break;
        }
        if (!instance.baked) {
            from = from * instance.object_to_world;
            to = to * instance.object_to_world;
        }
        Ray ray{from, 0, to - from, INFINITY};
        if (random_() % 4 == 0) ray.tfar = 1;
        if (random_() % 4 == 0) ray.tnear = 0.25f;
        if (random_() % 16 == 0)
            ray.direction[static_cast<int>(random_() % 3)] += 0x1p-20f;  // almost tangent
        if (ray.direction == Vec3(0, 0, 0)) ray.direction.x = 1;
        return ray;
    }

  private:
    static std::vector<Mat4> places() {
        Mat4 sheared, mirrored, thin, far;
        sheared[1][0] = 1.5f;
        sheared[2][1] = 0x1p-3f;
        mirrored[0][0] = -1;
        mirrored[3][0] = 0.5f;
        thin[2][2] = 0x1p-23f;
        thin[0][2] = 0x1p-12f;
        far[3][1] = 0x1p20f;
        far[0][0] = 0x1p10f;
        return {Mat4(), sheared, mirrored, thin, far};
    }

    /// Sizes in quarters, so that rays through lattice points touch; some are extreme.
    Shape shape(ShapeKind kind) {
        const auto size = [&] { return static_cast<float>(1 + random_() % 4) * 0.25f; };
        Shape shape;
        shape.kind = kind;
        shape.radius = size();
        shape.tube_radius = std::min(shape.radius, random_() % 8 == 0 ? 0x1p-10f : size());
        shape.size = {size() * 2, size() * 2, size() * 2};
        if (kind == ShapeKind::plane && random_() % 2 == 0) shape.size.x = 0;
        shape.height = size();
        shape.radius_top = size();
        shape.radius_bottom = random_() % 4 == 0 ? 0 : shape.radius_top;
        if (random_() % 2 == 0) shape.radius_bottom = size();
        shape.scale = size();
        return shape;
    }

    Vec3 lattice() {
        const auto coordinate = [&] { return static_cast<float>(random_() % 9) * 0.25f - 1; };
        const float x = coordinate(), y = coordinate();
        return {x, y, coordinate()};
    }

    std::mt19937 random_;
};

TEST(SecondOpinionOnShapes, AgreesWithTheRefereeOnEveryAdversarialRay) {
    const int rays = rational::wanted_rays(1000);
    constexpr int rays_of_a_scene = 100;
    std::atomic<int> hits = 0, ties = 0;
    std::array<std::atomic<int>, 7> by_kind{};
    parallel_for(static_cast<size_t>(rays / rays_of_a_scene), [&](size_t block) {
        ShapeAdversary adversary(static_cast<unsigned>(block * rays_of_a_scene));
        const Scene scene = adversary.scene();
        const auto bodies = bodies_of(scene);
        const Referee referee(scene);
        for (int i = 0; i < rays_of_a_scene; ++i) {
            const Ray ray = adversary.ray(scene);
            ShapeOpinion opinion = judge(ray, bodies);
            const Truth truth = referee.closest(ray);
            ASSERT_TRUE(truth.complete);
            ASSERT_EQ(truth.nearest, opinion.nearest) << "scene " << block << ", ray " << i;
            if (!opinion.t) continue;
            ASSERT_TRUE(opinion.t->rounds_to(truth.t)) << "scene " << block << ", ray " << i;
            ++hits;
            ties += opinion.nearest.size() > 1;
            for (const SurfaceId& id : opinion.nearest)
                ++by_kind[static_cast<size_t>(scene.shape(id.geometry).kind)];
        }
    });
    RecordProperty("hits", hits);
    EXPECT_GT(hits, rays / 4);
    EXPECT_GT(ties, rays / 50);
    for (const int count : by_kind) EXPECT_GT(count, rays / 100);
}

}  // namespace
}  // namespace sightline
