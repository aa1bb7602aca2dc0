#include "exact/referee.h"

#include "exact/arithmetic.h"
#include "exact/condition.h"
#include "exact/shape_roots.h"
#include "exact/sphere_filter.h"
#include "exact/triangle_form.h"

#include <algorithm>

namespace sightline {

InstancedTriangle instanced_triangle(const Scene& scene, const SurfaceId& id) {
    const Mesh& mesh = scene.meshes[id.geometry];
    const auto& corners = mesh.triangles[id.primitive];
    const Instance& instance = scene.instances[id.instance];
    return {mesh.positions[corners[0]], mesh.positions[corners[1]], mesh.positions[corners[2]],
            instance.baked ? nullptr : &instance.object_to_world};
}

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

InstancedShape shape_of(const Scene& scene, const SurfaceId& id) {
    const Instance& instance = scene.instances[id.instance];
    return {&scene.shape(id.geometry), instance.baked ? nullptr : &instance.object_to_world};
}

/// A surface that the ray hits, and bounds of t.
struct Candidate {
    SurfaceId id;
    Enclosure t;
    std::optional<RealRoot>
        root;  // t, if the surface is a shape; none if enclose_sphere_roots found t
};

RealRoot root_of(const Scene& scene, const Ray& ray, const Candidate& candidate) {
    if (candidate.root) return *candidate.root;
    if (!scene.is_mesh(candidate.id.geometry))
        return sphere_root(ray, shape_of(scene, candidate.id), candidate.t);
    const TriangleForm<Dyadic> form(ray, instanced_triangle(scene, candidate.id));
    return {form.distance, form.determinant()};
}

int compare_candidates(const Scene& scene, const Ray& ray, const Candidate& a, const Candidate& b) {
    if (a.t.high < b.t.low) return -1;
    if (b.t.high < a.t.low) return 1;
    if (scene.is_mesh(a.id.geometry) && scene.is_mesh(b.id.geometry))
        return compare_exactly(ray, instanced_triangle(scene, a.id),
                               instanced_triangle(scene, b.id));
    RealRoot x = root_of(scene, ray, a), y = root_of(scene, ray, b);
    return compare(x, y);
}

double rounded_t(const Scene& scene, const Ray& ray, const Candidate& candidate) {
    if (scene.is_mesh(candidate.id.geometry))
        return exact_t(ray, instanced_triangle(scene, candidate.id));
    return root_of(scene, ray, candidate).to_double();
}

/// Calls `found` for each crossing of the ray and the surface. Returns false if it is unjudged.
template <class Found>
bool find_candidates(const Scene& scene, const Ray& ray, const SurfaceId& id, const Found& found) {
    if (scene.is_mesh(id.geometry)) {
        const InstancedTriangle triangle = instanced_triangle(scene, id);
        if (exact_crossing(ray, triangle) == Crossing::hit)
            found(Candidate{id, enclose_t(ray, triangle), std::nullopt});
        return true;
    }
    const InstancedShape shape = shape_of(scene, id);
    if (shape.shape->kind == ShapeKind::sphere)
        if (const auto known = enclose_sphere_roots(ray, shape)) {
            for (int i = 0; i < known->count; ++i)
                found(Candidate{id, known->t[static_cast<size_t>(i)], std::nullopt});
            return true;
        }
    auto roots = shape_roots(ray, shape);
    if (!roots) return false;
    for (RealRoot& root : *roots) {
        const double t = root.to_double();
        found(Candidate{
            id, {std::nextafter(t, -infinity), std::nextafter(t, infinity)}, std::move(root)});
    }
    return true;
}

}  // namespace

Referee::Referee(const Scene& scene, Tolerances tolerances)
    : scene_(&scene), tolerances_(tolerances), surfaces_(scene) {
    check_arithmetic();
}

Truth Referee::closest(const Ray& ray) const {
    Truth truth;
    std::vector<Candidate> nearest;
    double tmax = exact_double(ray.tfar);
    surfaces_.search(ray, tmax, [&](const SurfaceId& id) {
        truth.complete &= find_candidates(*scene_, ray, id, [&](Candidate candidate) {
            const int order =
                nearest.empty() ? -1 : compare_candidates(*scene_, ray, candidate, nearest[0]);
            if (order > 0) return;
            if (order < 0) nearest.clear();
            tmax = std::min(tmax, candidate.t.high);
            nearest.push_back(std::move(candidate));
        });
        return true;
    });
    for (const Candidate& candidate : nearest) truth.nearest.push_back(candidate.id);
    std::sort(truth.nearest.begin(), truth.nearest.end());
    if (!nearest.empty()) truth.t = rounded_t(*scene_, ray, nearest[0]);
    return truth;
}

bool Referee::occluded(const Ray& ray, const SurfaceId& except) const {
    bool blocked = false;
    const double tmax = exact_double(ray.tfar);
    surfaces_.search(ray, tmax, [&](const SurfaceId& id) {
        if (id != except)
            find_candidates(*scene_, ray, id, [&](const Candidate&) { blocked = true; });
        return !blocked;
    });
    return blocked;
}

std::vector<ExactCrossing> Referee::all(const Ray& ray) const {
    std::vector<Candidate> candidates;
    const double tmax = exact_double(ray.tfar);
    surfaces_.search(ray, tmax, [&](const SurfaceId& id) {
        find_candidates(*scene_, ray, id,
                        [&](Candidate candidate) { candidates.push_back(std::move(candidate)); });
        return true;
    });
    std::sort(candidates.begin(), candidates.end(), [&](const Candidate& a, const Candidate& b) {
        const int order = compare_candidates(*scene_, ray, a, b);
        return order != 0 ? order < 0 : a.id < b.id;
    });
    std::vector<ExactCrossing> result;
    for (size_t i = 0; i < candidates.size(); ++i) {
        const Candidate& c = candidates[i];
        const bool tied = i > 0 && compare_candidates(*scene_, ray, candidates[i - 1], c) == 0;
        result.push_back(
            {c.id, rounded_t(*scene_, ray, c), c.root ? c.root->multiplicity() : 1, tied});
    }
    return result;
}

namespace {

bool has_surface(const Truth& truth, const Hit& hit) {
    return std::binary_search(truth.nearest.begin(), truth.nearest.end(), surface_of(hit));
}

/// The largest coordinate of the ray's origin and of its point at `t`.
float largest_coordinate(const Ray& ray, double t) {
    const Vec3d point = Vec3d(ray.origin) + Vec3d(ray.direction) * (std::isfinite(t) ? t : 0);
    double largest = static_cast<double>(max_abs_component(ray.origin));
    for (int i = 0; i < 3; ++i) largest = std::max(largest, std::abs(point[i]));
    return static_cast<float>(std::min(largest, 0x1p127));
}

/// The neighbours by an ulp of the largest coordinates in play.
std::array<Ray, 12> ulp_neighbours_of(const Ray& ray, double t) {
    return neighbours_of(ray, largest_coordinate(ray, t), max_abs_component(ray.direction));
}

/// Calls `is_right(neighbour)` until it returns true. `t`: of the point that matters.
template <class IsRight>
bool is_right_for_a_neighbour(const Ray& ray, double t, const IsRight& is_right) {
    return std::ranges::any_of(ulp_neighbours_of(ray, t), [&](const Ray& moved) {
        return has_exact_answer(moved) && is_right(moved);
    });
}

/// Whether a result is the nearest float, be it infinite or zero, or within the tolerance.
bool is_within(double value, double exact, double tolerance) {
    return value == static_cast<double>(static_cast<float>(exact)) ||
           std::abs(value - exact) <= tolerance;  // false for NaN
}

constexpr double float_ulp = 0x1p-23;  // of 1

/// The root of a shape along a ray that is nearest to `t`; NaN if there is none.
double nearest_root(const Scene& scene, const Ray& ray, const SurfaceId& id, double t) {
    double nearest = std::numeric_limits<double>::quiet_NaN();
    const auto roots = exact_roots(ray, shape_of(scene, id));
    for (const ExactRoot& root : roots.value_or(std::vector<ExactRoot>()))
        if (!(std::abs(nearest - t) <= std::abs(root.t - t))) nearest = root.t;
    return nearest;
}

/// How far one ulp of the ray moves the root `t` of a shape: by the roots of the neighbours, as
/// there is no first order where the ray touches.
double change_of_root(const Scene& scene, const Ray& ray, const SurfaceId& id, double t) {
    double change = 0;
    for (const Ray& moved : ulp_neighbours_of(ray, t)) {
        if (!has_exact_answer(moved)) continue;
        const double root = nearest_root(scene, moved, id, t);
        if (!std::isnan(root)) change = std::max(change, std::abs(root - t));
    }
    return change;
}

}  // namespace

/// Compares the numbers of a hit on a surface that the ray hits; `exact_t` is that of its point.
/// `least_size` as for change_by_rounding.
Verdict Referee::judge_numbers(const Ray& ray, const Hit& hit, double exact_t,
                               double least_size) const {
    const auto t = static_cast<double>(hit.t);
    const SurfaceId surface = surface_of(hit);
    if (!scene_->is_mesh(hit.geometry)) {
        const bool right =
            is_within(t, exact_t, tolerances_.t * float_ulp * std::abs(exact_t)) ||
            is_within(t, exact_t, tolerances_.t * change_of_root(*scene_, ray, surface, exact_t));
        return right ? Verdict::same : Verdict::wrong_t;
    }
    const InstancedTriangle triangle = instanced_triangle(*scene_, surface);
    const PlaneHit exact = plane_hit(ray, triangle);
    const HitChange change = change_by_rounding(ray, triangle, exact, least_size);
    // The change is that of half an ulp; a result is at best the nearest float.
    const auto allowed = [](double tolerance, double by_half_an_ulp, double value) {
        return 2 * tolerance * by_half_an_ulp + float_ulp * std::abs(value);
    };
    if (!is_within(t, exact.t, allowed(tolerances_.t, change.t, exact.t))) return Verdict::wrong_t;
    const auto u = static_cast<double>(hit.u), v = static_cast<double>(hit.v);
    const bool right = is_within(u, exact.u, allowed(tolerances_.uv, change.u, exact.u)) &&
                       is_within(v, exact.v, allowed(tolerances_.uv, change.v, exact.v));
    return right ? Verdict::same : Verdict::wrong_uv;
}

/// Whether the answer is the truth for a neighbour of the ray that was answered. Its t, u and v
/// are those of the ray, which lie as far off as the neighbour.
bool Referee::is_right_for_neighbour(const Ray& ray, const Hit& hit) const {
    const Truth truth = closest(ray);
    if (!hit) return truth.nearest.empty();
    const auto size = static_cast<double>(largest_coordinate(ray, truth.t));
    return has_surface(truth, hit) && judge_numbers(ray, hit, truth.t, size) == Verdict::same;
}

/// Whether the ray hits that surface at most one float ulp of t behind the nearest one, and the
/// numbers are right.
bool Referee::is_near_tie(const Ray& ray, const Truth& truth, const Hit& hit) const {
    const float far = std::nextafter(static_cast<float>(truth.t), INFINITY);
    return std::ranges::any_of(all(ray), [&](const ExactCrossing& crossing) {
        return crossing.surface == surface_of(hit) && static_cast<float>(crossing.t) <= far &&
               judge_numbers(ray, hit, crossing.t) == Verdict::same;
    });
}

Verdict Referee::judge(const Ray& ray, const Truth& truth, const Hit& hit,
                       const SurfaceId& source) const {
    if (!truth.complete) return Verdict::unjudged;
    if (!hit && truth.nearest.empty()) return Verdict::same;
    const bool right_surface = has_surface(truth, hit);
    const Verdict numbers =
        right_surface ? judge_numbers(ray, hit, truth.t) : Verdict::wrong_primitive;
    if (numbers == Verdict::same) return truth.nearest.size() > 1 ? Verdict::tie : Verdict::same;
    if (right_surface && scene_->is_mesh(hit.geometry)) return numbers;
    if (hit && !right_surface && !truth.nearest.empty() && is_near_tie(ray, truth, hit))
        return Verdict::near_tie;
    const double t = hit ? static_cast<double>(hit.t) : truth.t;
    const bool excusable = !hit || surface_of(hit) != source;
    if (excusable && is_right_for_a_neighbour(ray, t, [&](const Ray& moved) {
            return is_right_for_neighbour(moved, hit);
        }))
        return Verdict::undecidable;
    if (!hit) return Verdict::missed;
    return truth.nearest.empty() ? Verdict::false_hit : numbers;
}

Verdict Referee::judge_occlusion(const Ray& ray, const Truth& truth, bool blocked,
                                 const SurfaceId& source) const {
    const bool known = !truth.nearest.empty();
    if (!truth.complete && !known) return Verdict::unjudged;
    if (blocked == known) return Verdict::same;
    if (is_right_for_a_neighbour(ray, truth.t, [&](const Ray& moved) {
            return occluded(moved, blocked ? source : SurfaceId()) == blocked;
        }))
        return Verdict::undecidable;
    return blocked ? Verdict::false_hit : Verdict::missed;
}

bool is_wrong(Verdict verdict) {
    return verdict >= Verdict::missed && verdict <= Verdict::wrong_uv;
}

std::string_view name_of(Verdict verdict) {
    constexpr std::string_view names[] = {
        "same",    "tie",      "near_tie",    "missed",  "false_hit", "wrong_primitive",
        "wrong_t", "wrong_uv", "undecidable", "unjudged"};
    return names[static_cast<size_t>(verdict)];
}

}  // namespace sightline
