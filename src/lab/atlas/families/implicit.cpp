#include "lab/atlas/families.h"

#include "exact/shapes.h"
#include "exact/triangle.h"
#include "intersect/methods/implicits.h"
#include "intersect/shapes.h"

namespace sightline {
namespace {

struct ImplicitCase {
    Ray ray;
    Shape shape;
};

/// Ascending; double ones once.
using Roots = std::vector<double>;

Roots distinct_roots(const ImplicitCase& c) {
    Roots roots;
    if (!has_exact_answer(c.ray)) return roots;
    if (const auto found = exact_roots(c.ray, {&c.shape}))
        for (const ExactRoot& root : *found) roots.push_back(root.t);
    return roots;
}

struct ImplicitTruth {
    Roots roots;
    /// Numbers of roots of the rays that differ by one ulp in one coordinate; empty: not computed.
    mutable std::vector<int> neighbour_counts = {};
};

const std::vector<int>& neighbour_counts(const ImplicitCase& c, const ImplicitTruth& truth) {
    if (truth.neighbour_counts.empty())
        for (const Ray& ray : neighbours_of(c.ray))
            truth.neighbour_counts.push_back(
                static_cast<int>(distinct_roots({ray, c.shape}).size()));
    return truth.neighbour_counts;
}

template <class Solve>
Method<ImplicitCase> implicit_method(std::string name, Solve solve) {
    return case_method<ImplicitCase>(
        std::move(name), solve, [](const ImplicitCase&, const Roots& roots) {
            return answer_of(!roots.empty(), roots.empty() ? 0 : roots.front(),
                             static_cast<int>(roots.size()));
        });
}

/// As renders intersect shapes.
Roots analytic_roots(const ImplicitCase& c) {
    const ShapeRoots found = intersect_shape(c.shape, Vec3d(c.ray.origin), Vec3d(c.ray.direction),
                                             0, std::numeric_limits<double>::infinity());
    Roots roots;
    for (int i = 0; i < found.count; ++i)
        if (found.t[i] > 0) roots.push_back(found.t[i]);
    return roots;
}

template <class T>
Method<ImplicitCase> implicit_method(const ImplicitMethod<T>& method, const std::string& suffix) {
    return implicit_method(
        "implicit-" + std::string(method.name) + suffix, [method](const ImplicitCase& c) {
            Roots roots =
                implicit_roots(method, c.shape, Vec3d(c.ray.origin), Vec3d(c.ray.direction));
            std::erase_if(roots, [](double t) { return !(t > 0); });
            return roots;
        });
}

std::vector<Method<ImplicitCase>> all_implicit_methods() {
    std::vector<Method<ImplicitCase>> methods = {implicit_method("analytic", analytic_roots)};
    for (size_t i = 0; i < implicit_methods<float>().size(); ++i) {
        methods.push_back(implicit_method(implicit_methods<float>()[i], ""));
        methods.push_back(implicit_method(implicit_methods<double>()[i], "-double"));
    }
    return methods;
}

/// The gradient of the shape's function.
Vec3d gradient(const Shape& shape, const Vec3d& p) {
    const double x = p.x, y = p.y, z = p.z;
    if (shape.kind == ShapeKind::torus) {
        const double ring = static_cast<double>(shape.radius);
        const double across = std::sqrt(x * x + z * z), factor = 1 - ring / across;
        return {x * factor, y, z * factor};
    }
    const double ball = x * x + 2.25 * z * z + y * y - 1, square = 3 * ball * ball;
    return {square * 2 * x - 2 * x * y * y * y,
            square * 2 * y - 3 * y * y * (x * x + 0.1125 * z * z),
            square * 4.5 * z - 0.225 * z * y * y * y};
}

SurfaceCrossing crossing_of(const ImplicitCase& c, const ImplicitTruth& truth) {
    const double t = truth.roots.front();
    SurfaceCrossing crossing(c.ray, t, normalize(gradient(c.shape, point_at(c.ray, t))));
    crossing.input_sensitivity += 1;  // the shape's own sizes
    return crossing;
}

Measures implicit_measures(const ImplicitCase& c, const ImplicitTruth& truth,
                           const MethodAnswer& answer) {
    if (truth.roots.empty()) return {};
    return crossing_of(c, truth).measure(answer.t, gradient(c.shape, point_at(c.ray, answer.t)));
}

/// All crossings count. Where the ray touches the surface, or almost, either count is accepted.
Verdict implicit_verdict(const ImplicitCase& c, const ImplicitTruth& truth,
                         const MethodAnswer& answer) {
    const auto count = static_cast<int>(truth.roots.size());
    if (answer.count == count) return Verdict::same;
    if (std::ranges::count(neighbour_counts(c, truth), answer.count) > 0)
        return Verdict::undecidable;
    return answer.count < count ? Verdict::missed : Verdict::false_hit;
}

bool is_decidable_surface(const ImplicitCase& c, const ImplicitTruth& truth) {
    return std::ranges::all_of(neighbour_counts(c, truth), [&](int count) {
        return count == static_cast<int>(truth.roots.size());
    });
}

Problem<ImplicitCase, ImplicitTruth> implicit_problem() {
    return {.methods = all_implicit_methods(),
            .solve = [](const ImplicitCase& c) { return ImplicitTruth{distinct_roots(c)}; },
            .is_hit = [](const ImplicitTruth& truth) { return !truth.roots.empty(); },
            .is_decidable = is_decidable_surface,
            .condition =
                [](const ImplicitCase& c, const ImplicitTruth& truth) {
                    return truth.roots.empty() ? not_measured : crossing_of(c, truth).condition();
                },
            .measure = implicit_measures,
            .verdict = implicit_verdict};
}

Shape torus(double tube) {
    Shape shape;
    shape.kind = ShapeKind::torus;
    shape.radius = 1;
    shape.tube_radius = static_cast<float>(tube);
    return shape;
}

Shape heart() {
    Shape shape;
    shape.kind = ShapeKind::heart;
    return shape;
}

ImplicitCase distant_torus(double distance, Rng& rng) {
    const Vec3d from = rng.direction() * distance, target = rng.in_cube(0.8);
    return {aimed_ray(from, target, rng), torus(0.25)};
}

/// Along the plane that touches the torus from above (two double roots), or past its outer equator;
/// either is off by 1/knob tube radii, inwards or outwards.
ImplicitCase touching_torus(double knob, Rng& rng) {
    const double gap = rng.sign() / knob, turn = rng.uniform(0, 2 * M_PI);
    const Vec3d along(std::cos(turn), 0, std::sin(turn));
    Vec3d target, direction = along;
    if (rng.coin()) {
        const double x = rng.uniform(-0.9, 0.9);
        target = Vec3d(-along.z, 0, along.x) * x + Vec3d(0, 0.25 * (1 + gap), 0);
    } else {
        target = along * (1.25 + 0.25 * gap);
        direction = Vec3d(0, 1, 0);
    }
    return {aimed_ray(target - direction * rng.uniform(2, 3), target, rng), torus(0.25)};
}

ImplicitCase thin_torus(double ratio, Rng& rng) {
    const double tube = 1 / ratio, turn = rng.uniform(0, 2 * M_PI);
    const Vec3d target = Vec3d(std::cos(turn), 0, std::sin(turn)) + rng.direction(0, 1.5 * tube);
    return {aimed_ray(target + rng.direction(1, 3), target, rng), torus(tube)};
}

/// Close to the dimple at the top or the tip at the bottom, where the gradient vanishes.
ImplicitCase cusp(double knob, Rng& rng) {
    const Vec3d target = Vec3d(0, rng.sign(), 0) + rng.in_cube(1 / knob);
    return {aimed_ray(target + rng.direction(2, 4), target, rng), heart()};
}

/// Close to the plane y = 0, where rays have triple roots.
ImplicitCase equator(double knob, Rng& rng) {
    Vec3d target = rng.in_cube(0.8);
    target.y = rng.uniform(-1, 1) / knob;
    Vec3d back = rng.direction(3, 4);
    back.y /= knob;
    return {aimed_ray(target + back, target, rng), heart()};
}

}  // namespace

std::vector<Family> implicit_families() {
    const auto problem = implicit_problem();
    return {random_family("Q1", "distant tori", "distance / radius", powers(10, 1, 7, 2), problem,
                          distant_torus),
            random_family("Q2", "rays that touch a torus", "tube radius / gap", powers(10, 1, 9, 2),
                          problem, touching_torus),
            random_family("Q3", "thin tori", "radius / tube radius",
                          {{1.25}, {4}, {32}, {256}, {2048}}, problem, thin_torus),
            random_family("I1", "the heart's cusps", "size / distance from the cusp",
                          powers(10, 0, 6, 2), problem, cusp),
            random_family("I2", "the heart's equator", "size / distance from the equator",
                          powers(10, 0, 6, 2), problem, equator)};
}

}  // namespace sightline
