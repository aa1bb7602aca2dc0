#include "exact/boxes.h"

#include "exact/triangle_form.h"

#include <optional>
#include <vector>

namespace sightline {
namespace {

/// A value of t as numerator/denominator, denominator > 0.
template <class T>
struct Fraction {
    T numerator, denominator;
};

/// The segment misses the box if and only if some entry lies beyond some exit.
template <class T>
std::optional<bool> every_entry_before_every_exit(const std::vector<Fraction<T>>& entries,
                                                  const std::vector<Fraction<T>>& exits) {
    bool unknown = false;
    for (const auto& entry : entries)
        for (const auto& exit : exits) {
            const std::optional<int> gap =
                (exit.numerator * entry.denominator - entry.numerator * exit.denominator).sign();
            if (gap == -1) return false;
            unknown |= !gap;
        }
    return unknown ? std::nullopt : std::optional(true);
}

template <class T>
std::optional<bool> box_crossing(const Ray& ray, const Box3& box) {
    std::vector<Fraction<T>> entries = {{from_float<T>(ray.tnear), T(1)}}, exits;
    if (!std::isinf(ray.tfar)) exits.push_back({from_float<T>(ray.tfar), T(1)});
    for (int axis = 0; axis < 3; ++axis) {
        const float direction = ray.direction[axis], origin = ray.origin[axis];
        const float low = box.min[axis], high = box.max[axis];
        if (low > high || (direction == 0 && (origin < low || origin > high))) return false;
        if (direction == 0) continue;
        const T o = from_float<T>(origin), d = from_float<T>(std::abs(direction));
        const T to_low = from_float<T>(low) - o, to_high = from_float<T>(high) - o;
        entries.push_back({direction > 0 ? to_low : -to_high, d});
        exits.push_back({direction > 0 ? to_high : -to_low, d});
    }
    return every_entry_before_every_exit(entries, exits);
}

}  // namespace

bool exact_box_crossing(const Ray& ray, const Box3& box) {
    if (const auto known = box_crossing<Bounded>(ray, box)) return *known;
    return *box_crossing<Dyadic>(ray, box);
}

}  // namespace sightline
