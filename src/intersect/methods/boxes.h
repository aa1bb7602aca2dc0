#pragma once
// Ray against axis-aligned box, each method over any scalar T: whether the segment tnear ≤ t ≤ tfar
// has a point in common with the closed box.
#include "core/math.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>

namespace sightline {

/// A ray and a box in the scalar of a method.
template <class T>
struct BoxQuery {
    Imath::Vec3<T> origin, direction, low, high;
    T tnear, tfar;
};

/// Williams, Barrus, Morley and Shirley, An Efficient and Robust Ray-Box Intersection Algorithm,
/// JGT 10(1) 2005: multiply by 1/d, near and far plane by its sign, the x slab first. A 0·∞ there
/// propagates to the result.
template <class T>
bool box_by_reciprocal(const BoxQuery<T>& q) {
    T near = 0, far = 0;
    for (int i = 0; i < 3; ++i) {
        const T inverse = T(1) / q.direction[i];
        const bool negative = inverse < T(0);
        const T entry = ((negative ? q.high[i] : q.low[i]) - q.origin[i]) * inverse;
        const T exit = ((negative ? q.low[i] : q.high[i]) - q.origin[i]) * inverse;
        if (i > 0 && (near > exit || entry > far)) return false;
        near = i == 0 || entry > near ? entry : near;
        far = i == 0 || exit < far ? exit : far;
    }
    return near <= q.tfar && far >= q.tnear;
}

/// Kay and Kajiya, Ray Tracing Complex Scenes, SIGGRAPH 1986: divide, sort each pair.
template <class T>
bool box_by_division(const BoxQuery<T>& q) {
    T near = q.tnear, far = q.tfar;
    for (int i = 0; i < 3; ++i) {
        const T a = (q.low[i] - q.origin[i]) / q.direction[i];
        const T b = (q.high[i] - q.origin[i]) / q.direction[i];
        near = std::max(near, std::min(a, b));
        far = std::min(far, std::max(a, b));
    }
    return near <= far;
}

/// Ize, Robust BVH Ray Traversal, JCGT 2(2) 2013: the reciprocal form, the far end enlarged by two
/// ulps so that rounding cannot lose a box, and 0·∞ ignored through the order of the comparisons.
template <class T>
bool box_by_ize(const BoxQuery<T>& q) {
    constexpr T padding = 1 + 2 * std::numeric_limits<T>::epsilon();
    T near = q.tnear, far = q.tfar;
    for (int i = 0; i < 3; ++i) {
        const T inverse = T(1) / q.direction[i];
        const bool negative = inverse < T(0);
        const T entry = ((negative ? q.high[i] : q.low[i]) - q.origin[i]) * inverse;
        const T exit = ((negative ? q.low[i] : q.high[i]) - q.origin[i]) * inverse * padding;
        near = entry > near ? entry : near;
        far = exit < far ? exit : far;
    }
    return near <= far;
}

/// As Embree's robust mode: zero directions become 1e-18, both ends move outwards by three ulps.
template <class T>
bool box_as_embree_robust(const BoxQuery<T>& q) {
    constexpr T padding = 3 * std::numeric_limits<T>::epsilon();
    T near = q.tnear, far = q.tfar;
    for (int i = 0; i < 3; ++i) {
        const T d = std::abs(q.direction[i]) < T(1e-18) ? T(1e-18) : q.direction[i];
        const T inverse = T(1) / d;
        const bool negative = d < T(0);
        const T entry =
            ((negative ? q.high[i] : q.low[i]) - q.origin[i]) * (inverse * (1 - padding));
        const T exit =
            ((negative ? q.low[i] : q.high[i]) - q.origin[i]) * (inverse * (1 + padding));
        near = std::max(near, entry);
        far = std::min(far, exit);
    }
    return near <= far;
}

/// Never loses a box: for a zero direction, whether the origin lies in the slab is decided without
/// rounding; all other ends move outwards by the error bound of subtraction and division.
template <class T>
bool box_conservatively(const BoxQuery<T>& q) {
    constexpr T epsilon = std::numeric_limits<T>::epsilon();
    T near = q.tnear, far = q.tfar;
    for (int i = 0; i < 3; ++i) {
        const T o = q.origin[i], d = q.direction[i];
        if (d == T(0)) {
            if (o < q.low[i] || o > q.high[i]) return false;
            continue;
        }
        const T entry = ((d < T(0) ? q.high[i] : q.low[i]) - o) / d;
        const T exit = ((d < T(0) ? q.low[i] : q.high[i]) - o) / d;
        near = std::max(near, entry - std::abs(entry) * (2 * epsilon));
        far = std::min(far, exit + std::abs(exit) * (2 * epsilon));
    }
    return near <= far;
}

template <class T>
struct BoxMethod {
    std::string_view name;
    bool (*crosses)(const BoxQuery<T>&);
};

/// All box methods by name.
template <class T>
std::span<const BoxMethod<T>> box_methods() {
    static constexpr BoxMethod<T> methods[] = {{"reciprocal", box_by_reciprocal<T>},
                                               {"division", box_by_division<T>},
                                               {"ize", box_by_ize<T>},
                                               {"embree-robust", box_as_embree_robust<T>},
                                               {"conservative", box_conservatively<T>}};
    return methods;
}

}  // namespace sightline
