#include "intersect/bvh/traversal_kernel.h"

#include <hwy/cache_control.h>

#include <array>

// Highway compiles the code below once for each instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "intersect/bvh/traversal_kernel.cpp"
#include <hwy/foreach_target.h>
// Highway requires this order: the targets first.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sightline::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes8 = hn::CappedTag<float, 8>;
using Vector = hn::Vec<Lanes8>;
using Mask = hn::Mask<Lanes8>;

/// A child and the t at which its box is entered, as one number that orders by t ≥ 0.
using StackEntry = uint64_t;

HWY_INLINE StackEntry make_entry(NodeRef child, float t_near) {
    return uint64_t{std::bit_cast<uint32_t>(t_near)} << 32 | std::bit_cast<uint32_t>(child);
}

/// The progress of one ray through a BVH: the current node and the nodes still to visit.
struct TraversalState {
    // Seven siblings per level; build_bvh bounds the depth (max_heuristic_depth and the halvings
    // after it).
    static constexpr size_t stack_size = 7 * 64;

    NodeRef current;
    size_t depth = 0;
    std::array<StackEntry, stack_size> stack;

    /// Continues with the nearest entry that is not beyond t_max; false if there is none.
    HWY_INLINE bool pop(float t_max) {
        while (depth > 0) {
            const StackEntry entry = stack[--depth];
            if (std::bit_cast<float>(static_cast<uint32_t>(entry >> 32)) > t_max) continue;
            current = std::bit_cast<NodeRef>(static_cast<uint32_t>(entry));
            return true;
        }
        return false;
    }
};

/// A ray's constants for the slab test, broadcast to vectors.
struct BoxRay {
    Vector reciprocal[3], near_offset[3], far_reciprocal[3], far_offset[3], tnear;
    size_t near_plane[3], far_plane[3];  // offsets into BvhNode::planes, in floats

    HWY_INLINE void set(const TraversalRay& ray) {
        const Lanes8 d;
        // Far ends move out by as much as rounding may take from them and add to the near ones.
        constexpr float farther = 1 + 0x1p-20f;
        for (int i = 0; i < 3; ++i) {
            reciprocal[i] = hn::Set(d, ray.reciprocal[i]);
            near_offset[i] = hn::Set(d, ray.near_offset[i]);
            far_reciprocal[i] = hn::Set(d, ray.reciprocal[i] * farther);
            far_offset[i] = hn::Set(d, ray.far_offset[i] * farther);
            near_plane[i] = 8 * ray.near_plane[i];
            far_plane[i] = 8 * ray.far_plane[i];
        }
        tnear = hn::Set(d, ray.tnear + 0.0f);  // no negative zero: see StackEntry
    }
};

/// A bit for each child box that the ray may enter with t ≤ t_max, and the t of the entries.
HWY_INLINE uint32_t intersect_boxes(const BvhNode& node, const BoxRay& ray, float t_max,
                                    float* HWY_RESTRICT t_near) {
    const Lanes8 d;
    const float* planes = node.planes[0];
    uint32_t hits = 0;
    for (size_t i = 0; i < 8; i += hn::Lanes(d)) {
        const auto entry = [&](int axis) HWY_ATTR {
            return hn::MulAdd(hn::Load(d, planes + ray.near_plane[axis] + i), ray.reciprocal[axis],
                              ray.near_offset[axis]);
        };
        const auto exit = [&](int axis) HWY_ATTR {
            return hn::MulAdd(hn::Load(d, planes + ray.far_plane[axis] + i),
                              ray.far_reciprocal[axis], ray.far_offset[axis]);
        };
        const auto near = hn::Max(hn::Max(entry(0), entry(1)), hn::Max(entry(2), ray.tnear));
        const auto far = hn::Min(hn::Min(exit(0), exit(1)), hn::Min(exit(2), hn::Set(d, t_max)));
        hn::Store(near, d, t_near + i);
        uint8_t bits[8] = {};
        hn::StoreMaskBits(d, hn::Le(near, far), bits);
        hits |= static_cast<uint32_t>(bits[0]) << i;
    }
    return hits;
}

/// Prefetches all cache lines of an object.
template <class T>
HWY_INLINE void prefetch(const T* object) {
    const char* begin = reinterpret_cast<const char*>(object);
    for (size_t line = 0; line < sizeof(T); line += 64) hwy::Prefetch(begin + line);
}

/// Moves to the nearest child that the ray enters and pushes the others, far ones first; in any
/// order if the first hit ends the query, which sorting would only delay. Prefetches the children
/// if `ahead`. False if the ray enters none.
template <bool ahead>
HWY_INLINE bool descend(TraversalState& state, const std::vector<BvhNode>& nodes, const BoxRay& ray,
                        const TraversalLimits& limits) {
    const BvhNode& node = nodes[state.current.index()];
    alignas(64) float t_near[8];
    uint32_t hits = intersect_boxes(node, ray, limits.t_max * (1 + 0x1p-20f), t_near);
    if (hits == 0) return false;
    const auto next_hit = [&]() HWY_ATTR {
        const auto i = static_cast<size_t>(std::countr_zero(hits));
        hits &= hits - 1;
        if (ahead && !node.children[i].is_leaf()) prefetch(&nodes[node.children[i].index()]);
        return make_entry(node.children[i], t_near[i]);
    };
    // An insertion sort by minima and maxima: branches on which box is nearer would be
    // mispredicted.
    StackEntry nearest = next_hit();
    StackEntry* const bottom = &state.stack[state.depth];
    StackEntry* top = bottom;
    while (hits != 0) {
        StackEntry entry = next_hit();
        if (limits.stop_at_certain) {
            *top++ = entry;
            continue;
        }
        const StackEntry farther = std::max(nearest, entry);
        nearest = std::min(nearest, entry);
        entry = farther;
        for (StackEntry* slot = bottom; slot < top; ++slot) {
            const StackEntry lower = std::max(*slot, entry);
            entry = std::min(*slot, entry);
            *slot = lower;
        }
        *top++ = entry;
    }
    state.depth += static_cast<size_t>(top - bottom);
    state.current = std::bit_cast<NodeRef>(static_cast<uint32_t>(nearest));
    return true;
}

struct Vector3 {
    Vector x, y, z;
};

HWY_INLINE Vector dot(const Vector3& a, const Vector3& b) {
    return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

HWY_INLINE Vector norm1(const Vector3& a) {
    return hn::Add(hn::Add(hn::Abs(a.x), hn::Abs(a.y)), hn::Abs(a.z));
}

HWY_INLINE Vector3 cross(const Vector3& a, const Vector3& b) {
    return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
            hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}

HWY_INLINE Vector3 load(const float (&from)[3][8], size_t i) {
    const Lanes8 d;
    return {hn::Load(d, from[0] + i), hn::Load(d, from[1] + i), hn::Load(d, from[2] + i)};
}

// The triangle test. With s the vector from the origin to the first vertex, ab and ac the edges
// from there, n = ab × ac and r = s × d, the line hits if u = r·ac, v = −r·ab and
// w = n·d − u − v have the same sign, at t = s·n / n·d.
//
// Error bounds, with L the longer edge, all lengths in 1-norms, d in the maximum norm and units of
// rounding (2⁻²⁴) counted as in Higham, Accuracy and Stability of Numerical Algorithms, lemma 3.1:
// - u, v and w are off by less than 22 units of |d|·L·(|s| + L); 32 are allowed;
// - the numerator of t is off by less than 8 units of L²·|s|; 16 are allowed;
// - the denominator n·d is off by less than 8 units of |d|·L²; 32 are allowed.
// origin_slack adds to |s|, direction_size takes the place of |d|, and underflow_error is added to
// each. An overflow anywhere shows in the bound of u, v and w, which is larger than what it bounds.

/// The edge tests of some lanes of a block, and the terms that the interval of t shares with them.
struct EdgeTest {
    Vector3 s, normal;
    Vector determinant;  // n·d = u + v + w
    Vector distance;     // |s| with the origin's slack
    Vector edge;         // L
    Vector edge_rate;    // 32 units of |d|·L
    Vector error;        // of u, v and w
    Mask sound;          // nothing overflowed
    Mask missed;         // the line certainly misses
    Mask certain;        // the line certainly hits
};

HWY_INLINE EdgeTest test_edges(const TriangleBlock& block, size_t i, const TraversalRay& ray) {
    const Lanes8 d;
    const Vector3 origin = {hn::Set(d, ray.origin.x), hn::Set(d, ray.origin.y),
                            hn::Set(d, ray.origin.z)};
    const Vector3 direction = {hn::Set(d, ray.direction.x), hn::Set(d, ray.direction.y),
                               hn::Set(d, ray.direction.z)};
    const auto rate = hn::Set(d, 0x1p-19f * ray.direction_size);
    const Vector3 a = load(block.a, i), ab = load(block.ab, i), ac = load(block.ac, i);
    EdgeTest test;
    test.s = {hn::Sub(a.x, origin.x), hn::Sub(a.y, origin.y), hn::Sub(a.z, origin.z)};
    test.normal = cross(ab, ac);
    const Vector3 r = cross(test.s, direction);
    test.determinant = dot(test.normal, direction);
    const auto u = dot(r, ac), v = hn::Neg(dot(r, ab));
    const auto w = hn::Sub(hn::Sub(test.determinant, u), v);
    test.distance = hn::Add(norm1(test.s), hn::Set(d, ray.origin_slack));
    test.edge = hn::Max(norm1(ab), norm1(ac));
    test.edge_rate = hn::Mul(rate, test.edge);
    test.error = hn::MulAdd(test.edge_rate, hn::Add(test.distance, test.edge),
                            hn::Set(d, ray.underflow_error));
    const auto least = hn::Min(u, hn::Min(v, w)), most = hn::Max(u, hn::Max(v, w));
    const auto minus_error = hn::Neg(test.error);
    test.sound = hn::Lt(test.error, hn::Set(d, 0x1p100f));
    test.missed =
        hn::And(test.sound, hn::And(hn::Lt(least, minus_error), hn::Gt(most, test.error)));
    test.certain =
        hn::And(test.sound, hn::Or(hn::Gt(least, test.error), hn::Lt(most, minus_error)));
    return test;
}

/// Bounds of t; infinite if the denominator's sign is in doubt.
struct TInterval {
    Vector low, high;
};

HWY_INLINE TInterval enclose_t(const EdgeTest& test, const TraversalRay& ray) {
    const Lanes8 d;
    const auto inverse = hn::Div(hn::Set(d, 1.0f), test.determinant);
    const auto t = hn::Mul(dot(test.s, test.normal), inverse), abs_t = hn::Abs(t);
    const auto edge2 = hn::Mul(test.edge, test.edge);
    const auto numerator_error = hn::MulAdd(hn::Mul(hn::Set(d, 0x1p-20f), edge2), test.distance,
                                            hn::Set(d, ray.underflow_error));
    const auto error =
        hn::MulAdd(hn::MulAdd(abs_t, hn::Mul(test.edge_rate, test.edge), numerator_error),
                   hn::Abs(inverse), hn::Mul(abs_t, hn::Set(d, 0x1p-21f)));
    const auto known = hn::And(test.sound, hn::Gt(hn::Abs(test.determinant), test.error));
    const auto infinity = hn::Set(d, std::numeric_limits<float>::infinity());
    return {hn::IfThenElse(known, hn::Sub(t, error), hn::Neg(infinity)),
            hn::IfThenElse(known, hn::Add(t, error), infinity)};
}

/// Accepts a candidate that needs no decision, and passes any other to the visitor. Returns true to
/// stop.
HWY_INLINE bool report(const TriangleCandidate& candidate, TraversalLimits& limits,
                       TriangleVisitor& visitor) {
    if (candidate.certain && candidate.t_low > limits.certain_t_min &&
        candidate.t_high < limits.certain_t_max) {
        limits.pending_triangle = candidate.triangle;
        limits.certain_t_max = candidate.t_low;
        limits.t_max = std::min(limits.t_max, candidate.t_high);
        return limits.stop_at_certain;
    }
    // An overflow leaves a NaN in t_low: then nothing is known.
    return !(candidate.t_low > limits.t_max) && visitor.on_triangle(candidate, limits);
}

/// Reports the block's triangles that the ray hits or may hit. Returns true to stop.
HWY_INLINE bool test_block(const TriangleBlock& block, const TraversalRay& ray,
                           TraversalLimits& limits, TriangleVisitor& visitor) {
    const Lanes8 d;
    for (size_t i = 0; i < 8; i += hn::Lanes(d)) {
        const EdgeTest test = test_edges(block, i, ray);
        if (hn::AllTrue(d, test.missed)) continue;
        const TInterval t = enclose_t(test, ray);
        const auto out_of_range =
            hn::Or(hn::Gt(t.low, hn::Set(d, limits.t_max)), hn::Lt(t.high, hn::Set(d, ray.tnear)));
        alignas(64) float t_low[8], t_high[8];
        uint8_t excluded_bits[8] = {}, certain_bits[8] = {};
        hn::StoreMaskBits(d, hn::Or(test.missed, out_of_range), excluded_bits);
        hn::StoreMaskBits(d, test.certain, certain_bits);
        hn::Store(t.low, d, t_low);
        hn::Store(t.high, d, t_high);
        const uint32_t all = (1u << hn::Lanes(d)) - 1;
        for (uint32_t left = ~uint32_t{excluded_bits[0]} & all; left != 0; left &= left - 1) {
            const auto lane = static_cast<size_t>(std::countr_zero(left));
            const TriangleCandidate candidate = {block.triangle[i + lane],
                                                 (certain_bits[0] >> lane & 1) != 0, t_low[lane],
                                                 t_high[lane]};
            if (report(candidate, limits, visitor)) return true;
        }
    }
    return false;
}

enum class Step { more, done, stopped };

/// Visits the current node or leaf.
template <bool ahead>
HWY_INLINE Step advance(TraversalState& state, const TriangleBvh& bvh, const BoxRay& boxes,
                        const TraversalJob& job) {
    TraversalLimits& limits = *job.limits;
    if (state.current.is_leaf()) {
        for (uint32_t i = 0; i < state.current.count(); ++i)
            if (test_block(bvh.blocks[state.current.first() + i], *job.ray, limits, *job.visitor))
                return Step::stopped;
    } else if (descend<ahead>(state, bvh.bvh.nodes, boxes, limits)) {
        return Step::more;
    }
    return state.pop(limits.t_max) ? Step::more : Step::done;
}

void TraverseEach(const TriangleBvh& bvh, std::span<TraversalJob> jobs) {
    if (bvh.bvh.root.is_nothing()) return;
    for (TraversalJob& job : jobs) {
        TraversalState state;
        state.current = bvh.bvh.root;
        BoxRay boxes;
        boxes.set(*job.ray);
        Step step = Step::more;
        while (step == Step::more) step = advance<true>(state, bvh, boxes, job);
        job.stopped = step == Step::stopped;
    }
}

/// Prefetches what the next step reads.
HWY_INLINE void prefetch_next(const TraversalState& state, const TriangleBvh& bvh) {
    if (state.current.is_leaf())
        prefetch(&bvh.blocks[state.current.first()]);
    else
        prefetch(&bvh.bvh.nodes[state.current.index()]);
}

void TraverseInterleaved(const TriangleBvh& bvh, std::span<TraversalJob> jobs) {
    struct Slot {
        TraversalState state;
        BoxRay boxes;
        TraversalJob* job;
    };
    if (bvh.bvh.root.is_nothing()) return;
    std::array<Slot, 12> slots;
    std::array<uint8_t, 12> order = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};  // active slots first
    size_t next = 0, active = 0;
    const auto start = [&](Slot& slot) HWY_ATTR {
        slot.job = &jobs[next++];
        slot.boxes.set(*slot.job->ray);
        slot.state.current = bvh.bvh.root;
        slot.state.depth = 0;
    };
    while (active < slots.size() && next < jobs.size()) start(slots[active++]);
    while (active > 0)
        for (size_t i = 0; i < active; ++i) {
            Slot& slot = slots[order[i]];
            const Step step = advance<false>(slot.state, bvh, slot.boxes, *slot.job);
            if (step == Step::more) {
                prefetch_next(slot.state, bvh);
                continue;
            }
            slot.job->stopped = step == Step::stopped;
            if (next < jobs.size())
                start(slot);
            else
                std::swap(order[i], order[--active]);
        }
}

bool TraverseLeaves(const Bvh& bvh, const TraversalRay& ray, TraversalLimits& limits,
                    LeafVisitor& visitor) {
    TraversalState state;
    state.current = bvh.root;
    BoxRay boxes;
    boxes.set(ray);
    if (state.current.is_nothing()) return false;
    for (;;) {
        bool entered = true;
        while (entered && !state.current.is_leaf())
            entered = descend<true>(state, bvh.nodes, boxes, limits);
        if (entered && visitor.on_leaf(state.current.first(), state.current.count(), limits))
            return true;
        if (!state.pop(limits.t_max)) return false;
    }
}

const char* TargetName() { return hwy::TargetName(HWY_TARGET); }

}  // namespace sightline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline {

HWY_EXPORT(TraverseEach);
HWY_EXPORT(TraverseInterleaved);
HWY_EXPORT(TraverseLeaves);
HWY_EXPORT(TargetName);

bool traverse(const TriangleBvh& bvh, const TraversalRay& ray, TraversalLimits& limits,
              TriangleVisitor& visitor) {
    TraversalJob job{&ray, &limits, &visitor};
    traverse_each(bvh, {&job, 1});
    return job.stopped;
}

bool traverse(const Bvh& bvh, const TraversalRay& ray, TraversalLimits& limits,
              LeafVisitor& visitor) {
    return HWY_DYNAMIC_DISPATCH(TraverseLeaves)(bvh, ray, limits, visitor);
}

void traverse_each(const TriangleBvh& bvh, std::span<TraversalJob> jobs) {
    HWY_DYNAMIC_DISPATCH(TraverseEach)(bvh, jobs);
}

void traverse_interleaved(const TriangleBvh& bvh, std::span<TraversalJob> jobs) {
    HWY_DYNAMIC_DISPATCH(TraverseInterleaved)(bvh, jobs);
}

const char* vector_target() { return HWY_DYNAMIC_DISPATCH(TargetName)(); }

}  // namespace sightline
#endif
