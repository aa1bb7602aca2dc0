// Boxes: a ray against one box at a time.
#include "core/parallel.h"
#include "exact/boxes.h"
#include "exact/triangle.h"
#include "intersect/methods/boxes.h"
#include "lab/atlas/dice.h"
#include "lab/atlas/families.h"

namespace sightline {
namespace {

struct BoxCase {
    Ray ray;
    Box3 box;
};

/// The decisions of one method on queries that are ready in its scalar.
template <class T>
class BoxRun {
  public:
    BoxRun(const BoxMethod<T>& method, std::span<const BoxCase> cases)
        : method_(method), found_(cases.size()) {
        using V = Imath::Vec3<T>;
        for (const auto& [ray, box] : cases)
            queries_.push_back({V(ray.origin), V(ray.direction), V(box.min), V(box.max),
                                static_cast<T>(ray.tnear), static_cast<T>(ray.tfar)});
    }

    void run() {
        for (size_t i = 0; i < queries_.size(); ++i) found_[i] = method_.crosses(queries_[i]);
    }
    bool found(size_t i) const { return found_[i] != 0; }

  private:
    BoxMethod<T> method_;
    std::vector<BoxQuery<T>> queries_;
    std::vector<uint8_t> found_;
};

constexpr std::string_view prefix = "box-";

class BoxTrial : public Trial {
  public:
    explicit BoxTrial(std::vector<BoxCase> cases)
        : cases_(std::move(cases)), truths_(cases_.size()) {
        parallel_for(cases_.size(), [this](size_t i) { truths_[i] = crosses(cases_[i]); });
    }

    size_t size() const override { return cases_.size(); }

    std::vector<Entrant> entrants(const std::vector<std::string>& methods) override {
        std::vector<Entrant> result;
        for (const std::string& name : methods) {
            add<float>(name, "", result);
            add<double>(name, "-double", result);
        }
        return result;
    }

    Verdict judge(size_t i, const MethodAnswer& answer) const override {
        const bool found = bool(answer.hit), truth = hits(i);
        if (found == truth) return Verdict::same;
        // What a box guards is as close as the box: losing it is never excused.
        if (truth) return Verdict::missed;
        return decidable(i) ? Verdict::false_hit : Verdict::undecidable;
    }

    Measures measure(size_t, const MethodAnswer&) const override { return no_measures; }
    bool hits(size_t i) const override { return truths_[i] != 0; }
    double condition(size_t) const override { return not_measured; }

    bool decidable(size_t i) const override {
        for (Vec3 Ray::*part : {&Ray::origin, &Ray::direction})
            for (int axis = 0; axis < 3; ++axis)
                if (flips(i, [&](BoxCase& c) -> float& { return (c.ray.*part)[axis]; }))
                    return false;
        for (int axis = 0; axis < 3; ++axis)
            if (flips(i, [&](BoxCase& c) -> float& { return c.box.min[axis]; }) ||
                flips(i, [&](BoxCase& c) -> float& { return c.box.max[axis]; }))
                return false;
        return true;
    }

  private:
    static bool crosses(const BoxCase& c) {
        return has_exact_answer(c.ray) && exact_box_crossing(c.ray, c.box);
    }

    /// Whether moving one number by an ulp changes the truth.
    template <class Select>
    bool flips(size_t i, const Select& select) const {
        for (const float end : {-INFINITY, INFINITY}) {
            BoxCase moved = cases_[i];
            float& number = select(moved);
            number = std::nextafter(number, end);
            if (crosses(moved) != hits(i)) return true;
        }
        return false;
    }

    template <class T>
    void add(const std::string& name, std::string_view suffix, std::vector<Entrant>& result) const {
        for (const BoxMethod<T>& method : box_methods<T>()) {
            if (name != std::string(prefix) + std::string(method.name) + std::string(suffix))
                continue;
            const auto run = std::make_shared<BoxRun<T>>(method, cases_);
            result.push_back({name, [run] { run->run(); },
                              [run](size_t i) {
                                  MethodAnswer answer;
                                  if (run->found(i)) answer.hit.geometry = 0;
                                  return answer;
                              }});
        }
    }

    std::vector<BoxCase> cases_;
    std::vector<uint8_t> truths_;
};

Vec3d positive_size(Dice& dice) {
    const double x = dice.between(0.1, 1), y = dice.between(0.1, 1);
    return {x, y, dice.between(0.1, 1)};
}

Box3 box_near(const Vec3d& place, Dice& dice) {
    const Vec3 low(place + dice.vector(1));
    return {low, Vec3(Vec3d(low) + positive_size(dice))};
}

/// A corner, or a point of an edge.
Vec3d rim_point(const Box3& box, Dice& dice) {
    Vec3d p;
    for (int i = 0; i < 3; ++i) p[i] = static_cast<double>(dice.coin() ? box.min[i] : box.max[i]);
    if (dice.coin()) {
        const int axis = static_cast<int>(dice.below(3));
        p[axis] =
            dice.between(static_cast<double>(box.min[axis]), static_cast<double>(box.max[axis]));
    }
    return p;
}

BoxCase distant_corner(double distance, Dice& dice) {
    const Box3 box = box_near(Vec3d(0, 0, 0), dice);
    const Vec3d target = rim_point(box, dice);
    return {aimed_ray(target + dice.direction() * distance, target, dice), box};
}

/// A direction of ±0 along one axis or two, the origin on a plane of that slab or beside it.
BoxCase zero_direction(double which, Dice& dice) {
    const Box3 box = box_near(Vec3d(0, 0, 0), dice);
    const int code = static_cast<int>(which), axis = code / 4;
    Vec3d target;
    for (int i = 0; i < 3; ++i)
        target[i] = dice.between(static_cast<double>(box.min[i]), static_cast<double>(box.max[i]));
    BoxCase result = {aimed_ray(target + dice.direction() * 3.0, target, dice), box};
    result.ray.origin[axis] = code % 4 < 2 ? box.min[axis] : box.max[axis];
    result.ray.direction[axis] = code % 2 == 0 ? 0.0f : -0.0f;
    return result;
}

BoxCase flat_box(double flatness, Dice& dice) {
    Vec3d low = dice.vector(1), size = positive_size(dice);
    const int axis = static_cast<int>(dice.below(3));
    size[axis] = std::isinf(flatness) ? 0 : 1 / flatness;
    low[axis] = dice.coin() ? 0 : low[axis];
    const Box3 box(Vec3(low), Vec3(Vec3d(Vec3(low)) + size));
    const Vec3d target = rim_point(box, dice);
    return {aimed_ray(target + dice.direction(0.5, 3), target, dice), box};
}

BoxCase offset_corner(double offset, Dice& dice) {
    const Box3 box = box_near(dice.direction() * offset, dice);
    const Vec3d target = rim_point(box, dice);
    return {aimed_ray(target + dice.direction() * 3.0, target, dice), box};
}

std::vector<std::string> box_trial_methods() {
    std::vector<std::string> names;
    for (const auto& method : box_methods<float>())
        for (const char* suffix : {"", "-double"})
            names.push_back(std::string(prefix) + std::string(method.name) + suffix);
    return names;
}

}  // namespace

void add_box_families(std::vector<Family>& families) {
    const auto methods = box_trial_methods();
    families.push_back({"B1", "rays aimed at corners and edges of boxes", "distance / size",
                        powers(10, 0, 6), methods, trials_of<BoxTrial>(distant_corner), false});
    std::vector<KnobValue> cases;
    for (int i = 0; i < 12; ++i)
        cases.push_back({static_cast<double>(i), std::string(1, "xyz"[i / 4]) +
                                                     (i % 4 < 2 ? " low " : " high ") +
                                                     (i % 2 == 0 ? "+0" : "-0")});
    families.push_back({"B2", "directions of zero with the origin on the slab's plane", "case",
                        cases, methods, trials_of<BoxTrial>(zero_direction), false});
    auto flatness = powers(10, 0, 12, 2);
    flatness.push_back({std::numeric_limits<double>::infinity(), "flat"});
    families.push_back({"B3", "flat boxes", "width / thickness", flatness, methods,
                        trials_of<BoxTrial>(flat_box), false});
    auto offsets = powers(10, 1, 8);
    offsets.insert(offsets.begin(), KnobValue{0});
    families.push_back({"B4", "boxes far from the origin", "offset / size", offsets, methods,
                        trials_of<BoxTrial>(offset_corner), false});
}

}  // namespace sightline
