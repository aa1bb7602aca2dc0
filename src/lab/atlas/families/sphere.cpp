// Spheres: a ray against one sphere, or two about the same centre.
#include "core/parallel.h"
#include "exact/shapes.h"
#include "exact/triangle.h"
#include "intersect/methods/spheres.h"
#include "intersect/shapes.h"
#include "lab/atlas/dice.h"
#include "lab/atlas/families.h"

namespace sightline {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// The nearest of the spheres counts; most cases have one.
struct SphereCase {
    Ray ray;
    Vec3 centre;
    std::array<float, 2> radii{1, 0};  ///< 0: no second sphere
};

struct Nearest {
    uint32_t sphere = none;
    double t = std::numeric_limits<double>::infinity();
};

Nearest exact_nearest(const SphereCase& c) {
    Nearest nearest;
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

template <class T>
void try_method(const SphereMethod<T>& method, std::span<const SphereCase> cases,
                std::vector<Nearest>& found) {
    using V = Imath::Vec3<T>;
    for (size_t k = 0; k < cases.size(); ++k) {
        const SphereCase& c = cases[k];
        Nearest nearest;
        for (uint32_t i = 0; i < 2; ++i) {
            if (!(c.radii[i] > 0)) continue;
            const auto roots = method.roots(V(c.ray.origin), V(c.ray.direction), V(c.centre),
                                            static_cast<T>(c.radii[i]));
            for (int r = 0; r < roots.count; ++r) {
                const auto t = static_cast<double>(roots.t[r]);
                if (t > 0 && t < nearest.t) nearest = {i, t};
            }
        }
        found[k] = nearest;
    }
}

/// As renders intersect shapes.
void try_analytic(std::span<const SphereCase> cases, std::vector<Nearest>& found) {
    Shape sphere;
    for (size_t k = 0; k < cases.size(); ++k) {
        const SphereCase& c = cases[k];
        Nearest nearest;
        sphere.to_shape.setTranslation(-Vec3d(c.centre));
        sphere.to_object.setTranslation(Vec3d(c.centre));
        for (uint32_t i = 0; i < 2; ++i) {
            if (!(c.radii[i] > 0)) continue;
            sphere.radius = c.radii[i];
            const ShapeRoots roots =
                intersect_shape(sphere, Vec3d(c.ray.origin), Vec3d(c.ray.direction), 0,
                                std::numeric_limits<double>::infinity());
            for (int r = 0; r < roots.count; ++r)
                if (roots.t[r] > 0 && roots.t[r] < nearest.t) nearest = {i, roots.t[r]};
        }
        found[k] = nearest;
    }
}

constexpr std::string_view prefix = "sphere-";
constexpr std::string_view analytic = "analytic";

class SphereTrial : public Trial {
  public:
    explicit SphereTrial(std::vector<SphereCase> cases)
        : cases_(std::move(cases)), truths_(cases_.size()) {
        parallel_for(cases_.size(), [this](size_t i) { truths_[i] = exact_nearest(cases_[i]); });
    }

    size_t size() const override { return cases_.size(); }

    std::vector<Entrant> entrants(const std::vector<std::string>& methods) override {
        std::vector<Entrant> result;
        for (const std::string& name : methods) {
            const auto found = std::make_shared<std::vector<Nearest>>(cases_.size());
            const auto answer = [found](size_t i) {
                const Nearest& nearest = (*found)[i];
                MethodAnswer a;
                if (nearest.sphere != none) a.hit.geometry = 0;
                a.hit.primitive = nearest.sphere;
                a.t = nearest.t;
                return a;
            };
            if (name == analytic)
                result.push_back({name, [this, found] { try_analytic(cases_, *found); }, answer});
            add<float>(name, "", found, answer, result);
            add<double>(name, "-double", found, answer, result);
        }
        return result;
    }

    Verdict judge(size_t i, const MethodAnswer& answer) const override {
        const Nearest& truth = truths_[i];
        if (answer.hit.primitive == truth.sphere) return Verdict::same;
        if (moved_truth_is(i, answer.hit.primitive)) return Verdict::undecidable;
        if (truth.sphere == none) return Verdict::false_hit;
        return answer.hit ? Verdict::wrong_primitive : Verdict::missed;
    }

    Measures measure(size_t i, const MethodAnswer& answer) const override {
        if (!answer.hit) return no_measures;
        const MeetingPoint point = meeting_point(i);
        Measures measures = point.errors(answer.t);
        measures[static_cast<size_t>(Measure::normal_angle)] =
            angle_between(point.normal, position(i, answer.t) - Vec3d(cases_[i].centre));
        return measures;
    }

    bool hits(size_t i) const override { return truths_[i].sphere != none; }
    double condition(size_t i) const override {
        return hits(i) ? meeting_point(i).condition() : not_measured;
    }
    bool decidable(size_t i) const override { return !moved_truth_is_not(i, truths_[i].sphere); }

  private:
    Vec3d position(size_t i, double t) const {
        return Vec3d(cases_[i].ray.origin) + Vec3d(cases_[i].ray.direction) * t;
    }

    MeetingPoint meeting_point(size_t i) const {
        const SphereCase& c = cases_[i];
        const double t = truths_[i].t;
        const Vec3d centre(c.centre), normal = normalize(position(i, t) - centre);
        MeetingPoint point(c.ray, t, normal);
        point.reach +=
            absolute_dot(normal, centre) + static_cast<double>(c.radii[truths_[i].sphere]);
        return point;
    }

    /// Whether the rim is so far off, compared with what an ulp of any number can move it, that no
    /// neighbour can differ: half of what follows is a margin for this arithmetic's own rounding.
    bool clearly_decidable(size_t i) const {
        const SphereCase& c = cases_[i];
        if (c.radii[1] > 0) return false;
        const Vec3d o(c.ray.origin), d = normalize(Vec3d(c.ray.direction)), s = o - Vec3d(c.centre);
        const double rim = (s - d * dot(s, d)).length(), r = static_cast<double>(c.radii[0]);
        const double reach = o.length() + 2 * s.length() + Vec3d(c.centre).length() + r;
        const double sureness = std::min(std::abs(rim - r), std::abs(s.length() - r));
        return sureness > 0x1p-20 * reach;
    }

    /// Calls `visit` with the exact answer of each case that has one number moved by an ulp, until
    /// it returns true.
    template <class Visit>
    bool any_neighbour(size_t i, const Visit& visit) const {
        if (clearly_decidable(i)) return visit(truths_[i].sphere);
        const auto numbers = [](SphereCase& c) {
            return std::array<float*, 11>{
                &c.ray.origin.x,    &c.ray.origin.y,    &c.ray.origin.z, &c.ray.direction.x,
                &c.ray.direction.y, &c.ray.direction.z, &c.centre.x,     &c.centre.y,
                &c.centre.z,        &c.radii[0],        &c.radii[1]};
        };
        for (size_t n = 0; n < 11; ++n)
            for (const float end : {-infinity, infinity}) {
                SphereCase moved = cases_[i];
                float& number = *numbers(moved)[n];
                if (n == 10 && number == 0) continue;
                number = std::nextafter(number, end);
                if (visit(exact_nearest(moved).sphere)) return true;
            }
        return false;
    }
    bool moved_truth_is(size_t i, uint32_t sphere) const {
        return any_neighbour(i, [&](uint32_t truth) { return truth == sphere; });
    }
    bool moved_truth_is_not(size_t i, uint32_t sphere) const {
        return any_neighbour(i, [&](uint32_t truth) { return truth != sphere; });
    }

    template <class T, class GetAnswer>
    void add(const std::string& name, std::string_view suffix,
             const std::shared_ptr<std::vector<Nearest>>& found, const GetAnswer& answer,
             std::vector<Entrant>& result) const {
        for (const SphereMethod<T>& method : sphere_methods<T>())
            if (name == std::string(prefix) + std::string(method.name) + std::string(suffix))
                result.push_back({name,
                                  [this, found, method] { try_method<T>(method, cases_, *found); },
                                  answer});
    }

    std::vector<SphereCase> cases_;
    std::vector<Nearest> truths_;
};

/// A unit vector at right angles to `axis`.
Vec3d sideways(const Vec3d& axis, Dice& dice) { return normalize(cross(axis, dice.direction())); }

/// Aimed at up to twice the radius, so that about as many miss as hit.
SphereCase distant(double distance, Dice& dice) {
    const Vec3d from = dice.direction() * distance, target = dice.direction(0, 2);
    return {aimed_ray(from, target, dice), Vec3(0, 0, 0)};
}

/// Passing the rim at a distance of `1/knob` radii within or without.
SphereCase tangent(double knob, Dice& dice) {
    const Vec3d towards = dice.direction(), rim = sideways(towards, dice);
    const Vec3d centre = dice.vector(1);
    const double gap = (dice.coin() ? 1 : -1) / knob;
    const Vec3 middle(centre);
    const Vec3d target = Vec3d(middle) + rim * (1 + gap);
    const Vec3d from = target - towards * dice.between(2, 4);
    return {aimed_ray(from, target, dice), middle};
}

/// The eye stands one unit over a ball of radius `knob` that passes under the origin.
SphereCase ground(double radius, Dice& dice) {
    const auto r = static_cast<float>(radius);
    const double x = dice.between(-1, 1);
    const Vec3d eye(x, 1, dice.between(-1, 1));
    const double slope = std::pow(10, dice.between(-2, 0.5)), angle = dice.between(0, 2 * M_PI);
    const Vec3d d(std::cos(angle), -slope, std::sin(angle));
    return {{Vec3(eye), 0, Vec3(d)}, Vec3(0, -r, 0), {r, 0}};
}

/// The origin is a point of the surface as near as floats can be, `knob` from the world's origin.
SphereCase from_surface(double offset, Dice& dice) {
    const Vec3 centre(dice.direction() * offset);
    const Vec3 origin(Vec3d(centre) + dice.direction());
    return {{origin, 0, Vec3(dice.direction())}, centre};
}

/// Two spheres about one centre, radii 1 and 1 + 1/knob, from inside or outside.
SphereCase nested(double knob, Dice& dice) {
    const double outside = dice.coin() ? 3 : 0.3;
    const Vec3d from = dice.direction() * outside, target = dice.direction(0, 1);
    SphereCase result = {aimed_ray(from, target, dice), Vec3(0, 0, 0)};
    result.radii[1] = static_cast<float>(1 + 1 / knob);
    return result;
}

std::vector<std::string> sphere_trial_methods() {
    std::vector<std::string> names = {std::string(analytic)};
    for (const auto& method : sphere_methods<float>()) {
        names.push_back(std::string(prefix) + std::string(method.name));
        // The last computes in double whatever it is given.
        if (!names.back().ends_with("-double")) names.push_back(names.back() + "-double");
    }
    return names;
}

}  // namespace

void add_sphere_families(std::vector<Family>& families) {
    const auto methods = sphere_trial_methods();
    families.push_back({"S1",
                        "distant spheres",
                        "distance / radius",
                        {{2}, {20}, {200}, {2e3}, {2e4}, {2e5}, {2e6}, {2e7}, {1e8}},
                        methods,
                        trials_of<SphereTrial>(distant)});
    families.push_back({"S2", "rays that graze a sphere", "radius / gap", powers(10, 1, 15, 2),
                        methods, trials_of<SphereTrial>(tangent)});
    families.push_back({"S3", "an eye close over a large ball", "radius / height", powers(10, 1, 8),
                        methods, trials_of<SphereTrial>(ground)});
    families.push_back({"S4", "rays that start on a sphere", "offset / radius", powers(10, 0, 6),
                        methods, trials_of<SphereTrial>(from_surface)});
    families.push_back({"S5", "nested spheres", "radius / gap", powers(10, 1, 7), methods,
                        trials_of<SphereTrial>(nested)});
}

}  // namespace sightline
