#include "lab/atlas/families.h"

#include "exact/shapes.h"
#include "exact/triangle.h"
#include "intersect/methods/spheres.h"
#include "intersect/shapes.h"

namespace sightline {
namespace {

/// A ray against the nearest of one or two spheres.
struct SphereCase {
    Ray ray;
    Vec3 centre;
    std::array<float, 2> radii{1, 0};  ///< 0: no second sphere
};

struct NearestSphere {
    uint32_t index = none;  ///< into the radii
    double t = std::numeric_limits<double>::infinity();
};

NearestSphere exact_nearest(const SphereCase& c) {
    NearestSphere nearest;
    if (!has_exact_answer(c.ray)) return nearest;
    Shape sphere;
    sphere.to_shape.setTranslation(-Vec3d(c.centre));
    for (uint32_t i = 0; i < 2; ++i) {
        sphere.radius = c.radii[i];
        if (!(sphere.radius > 0)) continue;
        const auto roots = exact_roots(c.ray, {&sphere});
        if (roots && !roots->empty() && roots->front().t < nearest.t)
            nearest = {i, roots->front().t};
    }
    return nearest;
}

/// The least positive one of the roots that `roots_of(radius)` gives for each sphere.
template <class RootsOf>
NearestSphere nearest_of(const SphereCase& c, const RootsOf& roots_of) {
    NearestSphere nearest;
    for (uint32_t i = 0; i < 2; ++i) {
        if (!(c.radii[i] > 0)) continue;
        const auto roots = roots_of(c.radii[i]);
        for (int r = 0; r < roots.count; ++r) {
            const auto t = static_cast<double>(roots.t[r]);
            if (t > 0 && t < nearest.t) nearest = {i, t};
        }
    }
    return nearest;
}

template <class Solve>
Method<SphereCase> sphere_method(std::string name, Solve solve) {
    return case_method<SphereCase>(
        std::move(name), solve, [](const SphereCase&, const NearestSphere& nearest) {
            MethodAnswer answer = answer_of(nearest.index != none, nearest.t);
            answer.hit.primitive = nearest.index;
            return answer;
        });
}

template <class T>
Method<SphereCase> sphere_method(const SphereMethod<T>& method, const std::string& suffix) {
    return sphere_method("sphere-" + std::string(method.name) + suffix,
                         [method](const SphereCase& c) {
                             return nearest_of(c, [&](float radius) {
                                 using V = Imath::Vec3<T>;
                                 return method.roots(V(c.ray.origin), V(c.ray.direction),
                                                     V(c.centre), static_cast<T>(radius));
                             });
                         });
}

/// As renders intersect shapes.
Method<SphereCase> analytic_method() {
    return sphere_method("analytic", [sphere = Shape()](const SphereCase& c) mutable {
        sphere.to_shape.setTranslation(-Vec3d(c.centre));
        sphere.to_object.setTranslation(Vec3d(c.centre));
        return nearest_of(c, [&](float radius) {
            sphere.radius = radius;
            return intersect_shape(sphere, Vec3d(c.ray.origin), Vec3d(c.ray.direction), 0,
                                   std::numeric_limits<double>::infinity());
        });
    });
}

std::vector<Method<SphereCase>> all_sphere_methods() {
    std::vector<Method<SphereCase>> methods = {analytic_method()};
    for (size_t i = 0; i < sphere_methods<float>().size(); ++i) {
        const SphereMethod<float>& method = sphere_methods<float>()[i];
        methods.push_back(sphere_method(method, ""));
        if (!method.name.ends_with("-double"))
            methods.push_back(sphere_method(sphere_methods<double>()[i], "-double"));
    }
    return methods;
}

SurfaceCrossing crossing_of(const SphereCase& c, const NearestSphere& truth) {
    const Vec3d centre(c.centre), normal = normalize(point_at(c.ray, truth.t) - centre);
    SurfaceCrossing crossing(c.ray, truth.t, normal);
    crossing.input_sensitivity +=
        absolute_dot(normal, centre) + static_cast<double>(c.radii[truth.index]);
    return crossing;
}

Measures sphere_measures(const SphereCase& c, const NearestSphere& truth,
                         const MethodAnswer& answer) {
    if (!answer.hit) return {};
    return crossing_of(c, truth).measure(answer.t, point_at(c.ray, answer.t) - Vec3d(c.centre));
}

/// True if the ray passes the silhouette, and starts from the surface, at a distance that one ulp
/// of any number cannot bridge. Half of the bound is a margin for the rounding of this function.
bool clearly_decidable(const SphereCase& c) {
    if (c.radii[1] > 0) return false;
    const Vec3d o(c.ray.origin), d = normalize(Vec3d(c.ray.direction)), s = o - Vec3d(c.centre);
    const double line_distance = (s - d * dot(s, d)).length(), r = static_cast<double>(c.radii[0]);
    const double size = o.length() + 2 * s.length() + Vec3d(c.centre).length() + r;
    return std::min(std::abs(line_distance - r), std::abs(s.length() - r)) > 0x1p-20 * size;
}

std::vector<float*> sphere_numbers(SphereCase& c) {
    std::vector<float*> all;
    for (Vec3* v : {&c.ray.origin, &c.ray.direction, &c.centre})
        for (int axis = 0; axis < 3; ++axis) all.push_back(&(*v)[axis]);
    for (float& radius : c.radii)
        if (radius > 0) all.push_back(&radius);
    return all;
}

/// Whether one ulp changes the nearest sphere to one for which `predicate(index)` is true.
template <class Predicate>
bool any_neighbour(const SphereCase& c, const Predicate& predicate) {
    return !clearly_decidable(c) &&
           std::ranges::any_of(ulp_neighbours(c, sphere_numbers), [&](const SphereCase& moved) {
               return predicate(exact_nearest(moved).index);
           });
}

bool is_decidable_sphere(const SphereCase& c, const NearestSphere& truth) {
    return !any_neighbour(c, [&](uint32_t index) { return index != truth.index; });
}

Verdict sphere_verdict(const SphereCase& c, const NearestSphere& truth,
                       const MethodAnswer& answer) {
    const uint32_t answered = answer.hit.primitive;
    if (answered == truth.index) return Verdict::same;
    if (any_neighbour(c, [&](uint32_t index) { return index == answered; }))
        return Verdict::undecidable;
    if (truth.index == none) return Verdict::false_hit;
    return answer.hit ? Verdict::wrong_primitive : Verdict::missed;
}

Problem<SphereCase, NearestSphere> sphere_problem() {
    return {.methods = all_sphere_methods(),
            .solve = exact_nearest,
            .is_hit = [](const NearestSphere& truth) { return truth.index != none; },
            .is_decidable = is_decidable_sphere,
            .condition =
                [](const SphereCase& c, const NearestSphere& truth) {
                    return truth.index == none ? not_measured : crossing_of(c, truth).condition();
                },
            .measure = sphere_measures,
            .verdict = sphere_verdict};
}

/// A unit vector at right angles to `axis`.
Vec3d sideways(const Vec3d& axis, Rng& rng) { return normalize(cross(axis, rng.direction())); }

/// Towards a point up to two radii from the centre, so that about as many rays miss as hit.
SphereCase distant_sphere(double distance, Rng& rng) {
    const Vec3d from = rng.direction() * distance, target = rng.direction(0, 2);
    return {aimed_ray(from, target, rng), Vec3(0, 0, 0)};
}

/// Past the silhouette, 1/knob radii inside or outside.
SphereCase tangent(double knob, Rng& rng) {
    const Vec3d towards = rng.direction(), rim = sideways(towards, rng);
    const Vec3d centre = rng.in_cube(1);
    const double gap = (rng.coin() ? 1 : -1) / knob;
    const Vec3 middle(centre);
    const Vec3d target = Vec3d(middle) + rim * (1 + gap);
    const Vec3d from = target - towards * rng.uniform(2, 4);
    return {aimed_ray(from, target, rng), middle};
}

/// From an eye one unit above a ball whose top is the origin.
SphereCase ground(double radius, Rng& rng) {
    const auto r = static_cast<float>(radius);
    const double x = rng.uniform(-1, 1);
    const Vec3d eye(x, 1, rng.uniform(-1, 1));
    const double slope = std::pow(10, rng.uniform(-2, 0.5)), angle = rng.uniform(0, 2 * M_PI);
    const Vec3d d(std::cos(angle), -slope, std::sin(angle));
    return {{Vec3(eye), 0, Vec3(d)}, Vec3(0, -r, 0), {r, 0}};
}

/// From a point of the surface, rounded to floats; the centre is `offset` from the world's origin.
SphereCase from_surface(double offset, Rng& rng) {
    const Vec3 centre(rng.direction() * offset);
    const Vec3 origin(Vec3d(centre) + rng.direction());
    return {{origin, 0, Vec3(rng.direction())}, centre};
}

/// Two spheres about one centre, radii 1 and 1 + 1/knob, from inside or outside.
SphereCase nested_sphere(double knob, Rng& rng) {
    const double outside = rng.coin() ? 3 : 0.3;
    const Vec3d from = rng.direction() * outside, target = rng.direction(0, 1);
    SphereCase result = {aimed_ray(from, target, rng), Vec3(0, 0, 0)};
    result.radii[1] = static_cast<float>(1 + 1 / knob);
    return result;
}

}  // namespace

std::vector<Family> sphere_families() {
    const auto problem = sphere_problem();
    return {random_family("S1", "distant spheres", "distance / radius",
                          {{2}, {20}, {200}, {2e3}, {2e4}, {2e5}, {2e6}, {2e7}, {1e8}}, problem,
                          distant_sphere),
            random_family("S2", "rays that graze a sphere", "radius / gap", powers(10, 1, 15, 2),
                          problem, tangent),
            random_family("S3", "an eye close over a large ball", "radius / height",
                          powers(10, 1, 8), problem, ground),
            random_family("S4", "rays that start on a sphere", "offset / radius", powers(10, 0, 6),
                          problem, from_surface),
            random_family("S5", "nested spheres", "radius / gap", powers(10, 1, 7), problem,
                          nested_sphere)};
}

}  // namespace sightline
