// The torus and the heart: all roots of a ray, double ones once.
#include "core/parallel.h"
#include "exact/shapes.h"
#include "exact/triangle.h"
#include "intersect/methods/implicits.h"
#include "intersect/shapes.h"
#include "lab/atlas/dice.h"
#include "lab/atlas/families.h"

#include <deque>
#include <mutex>

namespace sightline {
namespace {

struct ImplicitCase {
    Ray ray;
    Shape shape;
};

using Roots = std::vector<double>;

Roots distinct_roots(const ImplicitCase& c) {
    Roots roots;
    if (!has_exact_answer(c.ray)) return roots;
    if (const auto found = exact_roots(c.ray, {&c.shape}))
        for (const ExactRoot& root : *found) roots.push_back(root.t);
    return roots;
}

Roots analytic_roots(const ImplicitCase& c) {
    const ShapeRoots found = intersect_shape(c.shape, Vec3d(c.ray.origin), Vec3d(c.ray.direction),
                                             0, std::numeric_limits<double>::infinity());
    Roots roots;
    for (int i = 0; i < found.count; ++i)
        if (found.t[i] > 0) roots.push_back(found.t[i]);
    return roots;
}

template <class T>
Roots method_roots(const ImplicitMethod<T>& method, const ImplicitCase& c) {
    Roots roots = implicit_roots(method, c.shape, Vec3d(c.ray.origin), Vec3d(c.ray.direction));
    std::erase_if(roots, [](double t) { return !(t > 0); });
    return roots;
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

constexpr std::string_view prefix = "implicit-";
constexpr std::string_view analytic = "analytic";

class ImplicitTrial : public Trial {
  public:
    explicit ImplicitTrial(std::vector<ImplicitCase> cases)
        : cases_(std::move(cases)),
          truths_(cases_.size()),
          neighbour_counts_(cases_.size()),
          once_(cases_.size()) {
        parallel_for(cases_.size(), [this](size_t i) { truths_[i] = distinct_roots(cases_[i]); });
    }

    size_t size() const override { return cases_.size(); }

    std::vector<Entrant> entrants(const std::vector<std::string>& methods) override {
        std::vector<Entrant> result;
        for (const std::string& name : methods) {
            if (name == analytic) add(name, analytic_roots, result);
            add_methods<float>(name, "", result);
            add_methods<double>(name, "-double", result);
        }
        return result;
    }

    /// All crossings count. Where the surface is only touched, or not quite, either is right.
    Verdict judge(size_t i, const MethodAnswer& answer) const override {
        const auto truth = static_cast<int>(truths_[i].size());
        if (answer.count == truth) return Verdict::same;
        const std::vector<int>& counts = neighbour_counts(i);
        if (std::find(counts.begin(), counts.end(), answer.count) != counts.end())
            return Verdict::undecidable;
        return answer.count < truth ? Verdict::missed : Verdict::false_hit;
    }

    Measures measure(size_t i, const MethodAnswer& answer) const override {
        if (truths_[i].empty()) return no_measures;
        const MeetingPoint point = meeting_point(i);
        Measures measures = point.errors(answer.t);
        measures[static_cast<size_t>(Measure::normal_angle)] =
            angle_between(point.normal, gradient(cases_[i].shape, position(i, answer.t)));
        return measures;
    }

    bool hits(size_t i) const override { return !truths_[i].empty(); }
    double condition(size_t i) const override {
        return hits(i) ? meeting_point(i).condition() : not_measured;
    }
    bool decidable(size_t i) const override {
        const auto truth = static_cast<int>(truths_[i].size());
        const std::vector<int>& counts = neighbour_counts(i);
        return std::all_of(counts.begin(), counts.end(), [&](int n) { return n == truth; });
    }

  private:
    Vec3d position(size_t i, double t) const {
        return Vec3d(cases_[i].ray.origin) + Vec3d(cases_[i].ray.direction) * t;
    }

    MeetingPoint meeting_point(size_t i) const {
        const double t = truths_[i].front();
        MeetingPoint point(cases_[i].ray, t, normalize(gradient(cases_[i].shape, position(i, t))));
        point.reach += 1;  // the shape's own sizes
        return point;
    }

    /// How many roots the rays have that are one ulp away in one coordinate.
    const std::vector<int>& neighbour_counts(size_t i) const {
        std::call_once(once_[i], [&] {
            ImplicitCase moved = cases_[i];
            for (const Ray& ray : neighbours_of(cases_[i].ray)) {
                moved.ray = ray;
                neighbour_counts_[i].push_back(static_cast<int>(distinct_roots(moved).size()));
            }
        });
        return neighbour_counts_[i];
    }

    template <class Method>
    void add(const std::string& name, const Method& method, std::vector<Entrant>& result) const {
        const auto found = std::make_shared<std::vector<Roots>>(size());
        result.push_back({name,
                          [this, found, method] {
                              for (size_t i = 0; i < size(); ++i) (*found)[i] = method(cases_[i]);
                          },
                          [found](size_t i) {
                              const Roots& roots = (*found)[i];
                              MethodAnswer answer;
                              answer.count = static_cast<int>(roots.size());
                              if (roots.empty()) return answer;
                              answer.hit.geometry = 0;
                              answer.t = roots.front();
                              return answer;
                          }});
    }

    template <class T>
    void add_methods(const std::string& name, std::string_view suffix,
                     std::vector<Entrant>& result) const {
        for (const ImplicitMethod<T>& method : implicit_methods<T>())
            if (name == std::string(prefix) + std::string(method.name) + std::string(suffix))
                add(
                    name, [method](const ImplicitCase& c) { return method_roots<T>(method, c); },
                    result);
    }

    std::vector<ImplicitCase> cases_;
    std::vector<Roots> truths_;
    mutable std::vector<std::vector<int>> neighbour_counts_;
    mutable std::deque<std::once_flag> once_;
};

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

ImplicitCase distant_torus(double distance, Dice& dice) {
    const Vec3d from = dice.direction() * distance, target = dice.vector(0.8);
    return {aimed_ray(from, target, dice), torus(0.25)};
}

/// Along the plane that touches the torus from above (a double root twice), or past its outer
/// equator, 1/knob of the tube's radius within or without.
ImplicitCase touching_torus(double knob, Dice& dice) {
    const double gap = dice.sign() / knob, turn = dice.between(0, 2 * M_PI);
    const Vec3d along(std::cos(turn), 0, std::sin(turn));
    Vec3d target, direction = along;
    if (dice.coin()) {
        const double x = dice.between(-0.9, 0.9);
        target = Vec3d(-along.z, 0, along.x) * x + Vec3d(0, 0.25 * (1 + gap), 0);
    } else {
        target = along * (1.25 + 0.25 * gap);
        direction = Vec3d(0, 1, 0);
    }
    return {aimed_ray(target - direction * dice.between(2, 3), target, dice), torus(0.25)};
}

ImplicitCase thin_torus(double ratio, Dice& dice) {
    const double tube = 1 / ratio, turn = dice.between(0, 2 * M_PI);
    const Vec3d target = Vec3d(std::cos(turn), 0, std::sin(turn)) + dice.direction(0, 1.5 * tube);
    return {aimed_ray(target + dice.direction(1, 3), target, dice), torus(tube)};
}

/// About the dimple above or the point below, where the gradient vanishes.
ImplicitCase cusp(double knob, Dice& dice) {
    const Vec3d target = Vec3d(0, dice.sign(), 0) + dice.vector(1 / knob);
    return {aimed_ray(target + dice.direction(2, 4), target, dice), heart()};
}

/// Close to the plane y = 0, where rays have triple roots.
ImplicitCase equator(double knob, Dice& dice) {
    Vec3d target = dice.vector(0.8);
    target.y = dice.between(-1, 1) / knob;
    Vec3d back = dice.direction(3, 4);
    back.y /= knob;
    return {aimed_ray(target + back, target, dice), heart()};
}

std::vector<std::string> implicit_trial_methods() {
    std::vector<std::string> names = {std::string(analytic)};
    for (const auto& method : implicit_methods<float>())
        for (const char* suffix : {"", "-double"})
            names.push_back(std::string(prefix) + std::string(method.name) + suffix);
    return names;
}

}  // namespace

void add_implicit_families(std::vector<Family>& families) {
    const auto methods = implicit_trial_methods();
    families.push_back({"Q1", "distant tori", "distance / radius", powers(10, 1, 7, 2), methods,
                        trials_of<ImplicitTrial>(distant_torus)});
    families.push_back({"Q2", "rays that touch a torus", "tube radius / gap", powers(10, 1, 9, 2),
                        methods, trials_of<ImplicitTrial>(touching_torus)});
    families.push_back({"Q3",
                        "thin tori",
                        "radius / tube radius",
                        {{1.25}, {4}, {32}, {256}, {2048}},
                        methods,
                        trials_of<ImplicitTrial>(thin_torus)});
    families.push_back({"I1", "the heart's cusps", "size / distance from the cusp",
                        powers(10, 0, 6, 2), methods, trials_of<ImplicitTrial>(cusp)});
    families.push_back({"I2", "the heart's equator", "size / distance from the equator",
                        powers(10, 0, 6, 2), methods, trials_of<ImplicitTrial>(equator)});
}

}  // namespace sightline
