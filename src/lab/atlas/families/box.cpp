#include "lab/atlas/families.h"

#include "exact/boxes.h"
#include "exact/triangle.h"
#include "intersect/methods/boxes.h"

namespace sightline {
namespace {

struct BoxCase {
    Ray ray;
    Box3 box;
};

bool crosses_exactly(const BoxCase& c) {
    return has_exact_answer(c.ray) && exact_box_crossing(c.ray, c.box);
}

std::vector<float*> box_numbers(BoxCase& c) {
    std::vector<float*> all;
    for (Vec3* v : {&c.ray.origin, &c.ray.direction, &c.box.min, &c.box.max})
        for (int axis = 0; axis < 3; ++axis) all.push_back(&(*v)[axis]);
    return all;
}

bool is_decidable(const BoxCase& c, bool truth) {
    return std::ranges::all_of(ulp_neighbours(c, box_numbers), [&](const BoxCase& moved) {
        return crosses_exactly(moved) == truth;
    });
}

/// The queries are converted to the method's scalar before the timed run.
template <class T>
Method<BoxCase> box_method(const BoxMethod<T>& method, const std::string& suffix) {
    return {"box-" + std::string(method.name) + suffix, [method](std::span<const BoxCase> cases) {
                using V = Imath::Vec3<T>;
                std::vector<BoxQuery<T>> queries;
                for (const auto& [ray, box] : cases)
                    queries.push_back({V(ray.origin), V(ray.direction), V(box.min), V(box.max),
                                       static_cast<T>(ray.tnear), static_cast<T>(ray.tfar)});
                return solve_each(std::move(queries), method.crosses,
                                  [](const auto&, bool found) { return answer_of(found); });
            }};
}

std::vector<Method<BoxCase>> box_methods_in_both_precisions() {
    std::vector<Method<BoxCase>> methods;
    for (size_t i = 0; i < box_methods<float>().size(); ++i) {
        methods.push_back(box_method(box_methods<float>()[i], ""));
        methods.push_back(box_method(box_methods<double>()[i], "-double"));
    }
    return methods;
}

Vec3d random_box_size(Rng& rng) {
    const double x = rng.uniform(0.1, 1), y = rng.uniform(0.1, 1);
    return {x, y, rng.uniform(0.1, 1)};
}

Box3 random_box(const Vec3d& near, Rng& rng) {
    const Vec3 low(near + rng.in_cube(1));
    return {low, Vec3(Vec3d(low) + random_box_size(rng))};
}

/// A corner of the box, or a point of an edge.
Vec3d rim_point(const Box3& box, Rng& rng) {
    Vec3d p;
    for (int i = 0; i < 3; ++i) p[i] = static_cast<double>(rng.coin() ? box.min[i] : box.max[i]);
    if (rng.coin()) {
        const int axis = static_cast<int>(rng.below(3));
        p[axis] =
            rng.uniform(static_cast<double>(box.min[axis]), static_cast<double>(box.max[axis]));
    }
    return p;
}

BoxCase distant_corner(double distance, Rng& rng) {
    const Box3 box = random_box(Vec3d(0, 0, 0), rng);
    const Vec3d target = rim_point(box, rng);
    return {aimed_ray(target + rng.direction() * distance, target, rng), box};
}

/// The direction is ±0 along one axis and the origin lies on a plane of that slab. `which` counts
/// through axes, planes and signs.
BoxCase zero_direction(double which, Rng& rng) {
    const Box3 box = random_box(Vec3d(0, 0, 0), rng);
    const int code = static_cast<int>(which), axis = code / 4;
    Vec3d target;
    for (int i = 0; i < 3; ++i)
        target[i] = rng.uniform(static_cast<double>(box.min[i]), static_cast<double>(box.max[i]));
    BoxCase result = {aimed_ray(target + rng.direction() * 3.0, target, rng), box};
    result.ray.origin[axis] = code % 4 < 2 ? box.min[axis] : box.max[axis];
    result.ray.direction[axis] = code % 2 == 0 ? 0.0f : -0.0f;
    return result;
}

BoxCase flat_box(double flatness, Rng& rng) {
    Vec3d low = rng.in_cube(1), size = random_box_size(rng);
    const int axis = static_cast<int>(rng.below(3));
    size[axis] = std::isinf(flatness) ? 0 : 1 / flatness;
    low[axis] = rng.coin() ? 0 : low[axis];
    const Box3 box(Vec3(low), Vec3(Vec3d(Vec3(low)) + size));
    const Vec3d target = rim_point(box, rng);
    return {aimed_ray(target + rng.direction(0.5, 3), target, rng), box};
}

BoxCase offset_corner(double offset, Rng& rng) {
    const Box3 box = random_box(rng.direction() * offset, rng);
    const Vec3d target = rim_point(box, rng);
    return {aimed_ray(target + rng.direction() * 3.0, target, rng), box};
}

Problem<BoxCase, bool> box_problem() {
    return {.methods = box_methods_in_both_precisions(),
            .solve = crosses_exactly,
            .is_hit = std::identity(),
            .is_decidable = is_decidable,
            // A lost box is never excused: the surface in it may be as close to the ray as the box.
            .verdict = [](const BoxCase& c, bool truth, const MethodAnswer& answer) {
                return hit_or_miss(answer, truth,
                                   [&] { return !truth && !is_decidable(c, truth); });
            }};
}

}  // namespace

std::vector<Family> box_families() {
    const auto problem = box_problem();
    std::vector<std::string> slabs;
    for (const char* axis : {"x", "y", "z"})
        for (const char* plane : {" low", " high"})
            for (const char* zero : {" +0", " -0"})
                slabs.push_back(axis + std::string(plane) + zero);
    auto flatness = powers(10, 0, 12, 2);
    flatness.push_back({std::numeric_limits<double>::infinity(), "flat"});
    std::vector<Family> families = {
        random_family("B1", "rays aimed at corners and edges of boxes", "distance / size",
                      powers(10, 0, 6), problem, distant_corner),
        random_family("B2", "directions of zero with the origin on the slab's plane", "case",
                      numbered(slabs), problem, zero_direction),
        random_family("B3", "flat boxes", "width / thickness", flatness, problem, flat_box),
        random_family("B4", "boxes far from the origin", "offset / size", zero_and_powers(10, 1, 8),
                      problem, offset_corner)};
    for (Family& family : families) family.false_hits_are_wrong = false;
    return families;
}

}  // namespace sightline
