#include "intersect/bvh/traversal_kernel.h"

#include <hwy/cache_control.h>

#include <array>

// Highway compiles what follows once for each instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "intersect/bvh/traversal_kernel.cpp"
#include <hwy/foreach_target.h>
// Highway's own order: the targets first.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sightline::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes8 = hn::CappedTag<float, 8>;
using Vector = hn::Vec<Lanes8>;

/// A link and where its box is entered, as one number that orders by the latter: t ≥ 0.
using StackEntry = uint64_t;

HWY_INLINE StackEntry entry_of(TreeLink link, float near) {
    return uint64_t{std::bit_cast<uint32_t>(near)} << 32 | std::bit_cast<uint32_t>(link);
}

/// One ray's way through a tree: where it stands and what is still to visit.
struct Walk {
    // Depth is bounded by deepest_heuristic_split and the halvings after it; see bvh_build.cpp.
    static constexpr size_t stack_size = 7 * 64;

    TreeLink current;
    size_t depth = 0;
    std::array<StackEntry, stack_size> stack;

    /// Goes on with the nearest entry that is not beyond `reach`; false at the end.
    HWY_INLINE bool pop(float reach) {
        while (depth > 0) {
            const StackEntry entry = stack[--depth];
            if (std::bit_cast<float>(static_cast<uint32_t>(entry >> 32)) > reach) continue;
            current = std::bit_cast<TreeLink>(static_cast<uint32_t>(entry));
            return true;
        }
        return false;
    }
};

/// A ray's constants for boxes, spread over vectors.
struct BoxRay {
    Vector reciprocal[3], near_offset[3], far_reciprocal[3], far_offset[3], tnear;
    size_t near_plane[3], far_plane[3];  // offsets into WideNode::planes, in floats

    HWY_INLINE void set(const TreeRay& ray) {
        const Lanes8 d;
        // Far ends move out by what rounding may take from them and add to the near ones.
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

/// Bits of the node's boxes that the ray may enter with t ≤ reach, and where.
HWY_INLINE uint32_t enter_boxes(const WideNode& node, const BoxRay& ray, float reach,
                                float* HWY_RESTRICT entries) {
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
        const auto far = hn::Min(hn::Min(exit(0), exit(1)), hn::Min(exit(2), hn::Set(d, reach)));
        hn::Store(near, d, entries + i);
        uint8_t bits[8] = {};
        hn::StoreMaskBits(d, hn::Le(near, far), bits);
        hits |= static_cast<uint32_t>(bits[0]) << i;
    }
    return hits;
}

/// Asks memory for all of an object.
template <class T>
HWY_INLINE void prefetch(const T* object) {
    const char* begin = reinterpret_cast<const char*>(object);
    for (size_t line = 0; line < sizeof(T); line += 64) hwy::Prefetch(begin + line);
}

/// Moves to the nearest entered child and leaves the others on the stack, far ones below; asks
/// memory for them where `ahead`. False where none is entered.
template <bool ahead>
HWY_INLINE bool descend(Walk& walk, const std::vector<WideNode>& nodes, const BoxRay& ray,
                        float reach) {
    const WideNode& node = nodes[walk.current.index()];
    alignas(64) float entries[8];
    uint32_t hits = enter_boxes(node, ray, reach * (1 + 0x1p-20f), entries);
    if (hits == 0) return false;
    const auto take = [&]() HWY_ATTR {
        const auto i = static_cast<size_t>(std::countr_zero(hits));
        hits &= hits - 1;
        if (ahead && !node.links[i].is_leaf()) prefetch(&nodes[node.links[i].index()]);
        return entry_of(node.links[i], entries[i]);
    };
    // Minima and maxima instead of comparisons: which box is nearer cannot be foretold.
    StackEntry nearest = take();
    StackEntry* const bottom = &walk.stack[walk.depth];
    StackEntry* top = bottom;
    while (hits != 0) {
        StackEntry entry = take();
        const StackEntry farther = std::max(nearest, entry);
        nearest = std::min(nearest, entry);
        entry = farther;
        for (StackEntry* place = bottom; place < top; ++place) {
            const StackEntry lower = std::max(*place, entry);
            entry = std::min(*place, entry);
            *place = lower;
        }
        *top++ = entry;
    }
    walk.depth += static_cast<size_t>(top - bottom);
    walk.current = std::bit_cast<TreeLink>(static_cast<uint32_t>(nearest));
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

/// Notes what is sure, offers what must be judged. True: the search may stop.
HWY_INLINE bool judge_lane(const Finding& finding, Judge& judge) {
    if (finding.certain && finding.low > judge.sure_from && finding.high < judge.sure_to) {
        judge.found = finding.triangle;
        judge.sure_to = finding.low;
        judge.reach = std::min(judge.reach, finding.high);
        return judge.stops_at_sure;
    }
    // What overflowed is no number, and nothing is known of it.
    return !(finding.low > judge.reach) && judge.offer(finding);
}

/// Offers the block's triangles that the ray hits or may hit. True: the search may stop.
///
/// With s the vector to the first vertex and L the longer edge from there, all in 1-norms, each of
/// the edge functions u, v and w is off by less than 22 units of |d|∞·L·(|s| + L), counting every
/// rounding as in Higham's lemma 3.1; 32 are allowed. The numerator and the denominator of t are
/// off by less than 8 units of L²·|s| and of |d|∞·L²; 16 are allowed.
HWY_INLINE bool test_block(const TriangleBlock& block, const TreeRay& ray, Judge& judge) {
    const Lanes8 d;
    const Vector3 origin = {hn::Set(d, ray.origin.x), hn::Set(d, ray.origin.y),
                            hn::Set(d, ray.origin.z)};
    const Vector3 direction = {hn::Set(d, ray.direction.x), hn::Set(d, ray.direction.y),
                               hn::Set(d, ray.direction.z)};
    const auto per_edge = hn::Set(d, 0x1p-19f * ray.direction_doubt * ray.fastest);
    for (size_t i = 0; i < 8; i += hn::Lanes(d)) {
        const Vector3 a = load(block.a, i), ab = load(block.ab, i), ac = load(block.ac, i);
        const Vector3 s = {hn::Sub(a.x, origin.x), hn::Sub(a.y, origin.y), hn::Sub(a.z, origin.z)};
        const Vector3 normal = cross(ab, ac), r = cross(s, direction);
        const auto across = dot(normal, direction);
        const auto u = dot(r, ac), v = hn::Neg(dot(r, ab)), w = hn::Sub(hn::Sub(across, u), v);
        const auto distance = hn::Add(norm1(s), hn::Set(d, ray.reach));
        const auto edge = hn::Max(norm1(ab), norm1(ac)), per_reach = hn::Mul(per_edge, edge);
        const auto error =
            hn::MulAdd(per_reach, hn::Add(distance, edge), hn::Set(d, ray.underflow));
        const auto least = hn::Min(u, hn::Min(v, w)), most = hn::Max(u, hn::Max(v, w));
        const auto missed = hn::And(hn::Lt(least, hn::Neg(error)), hn::Gt(most, error));
        // An overflow anywhere shows in the error bound, which is larger than what it bounds.
        const auto sound = hn::Lt(error, hn::Set(d, 0x1p100f));
        if (hn::AllTrue(d, hn::And(missed, sound))) continue;

        const auto certain =
            hn::And(sound, hn::Or(hn::Gt(least, error), hn::Lt(most, hn::Neg(error))));
        const auto size = hn::Abs(across);
        const auto inverse = hn::Div(hn::Set(d, 1.0f), across);
        const auto t = hn::Mul(dot(s, normal), inverse), abs_t = hn::Abs(t);
        const auto edge2 = hn::Mul(edge, edge);
        const auto numerator_error =
            hn::MulAdd(hn::Mul(hn::Set(d, 0x1p-20f), edge2), distance, hn::Set(d, ray.underflow));
        const auto slack = hn::MulAdd(hn::MulAdd(abs_t, hn::Mul(per_reach, edge), numerator_error),
                                      hn::Abs(inverse), hn::Mul(abs_t, hn::Set(d, 0x1p-21f)));
        // Where the denominator's sign is in doubt nothing is known of t.
        const auto known = hn::And(sound, hn::Gt(size, error));
        const auto infinity = hn::Set(d, std::numeric_limits<float>::infinity());
        const auto low = hn::IfThenElse(known, hn::Sub(t, slack), hn::Neg(infinity));
        const auto high = hn::IfThenElse(known, hn::Add(t, slack), infinity);
        const auto beyond =
            hn::Or(hn::Gt(low, hn::Set(d, judge.reach)), hn::Lt(high, hn::Set(d, ray.tnear)));
        const auto gone = hn::Or(hn::And(missed, sound), beyond);

        alignas(64) float lows[8], highs[8];
        uint8_t gone_bits[8] = {}, certain_bits[8] = {};
        hn::StoreMaskBits(d, gone, gone_bits);
        hn::StoreMaskBits(d, certain, certain_bits);
        hn::Store(low, d, lows);
        hn::Store(high, d, highs);
        const uint32_t all = (1u << hn::Lanes(d)) - 1;
        for (uint32_t left = ~uint32_t{gone_bits[0]} & all; left != 0; left &= left - 1) {
            const auto lane = static_cast<size_t>(std::countr_zero(left));
            if (judge_lane({block.triangle[i + lane], (certain_bits[0] >> lane & 1) != 0,
                            lows[lane], highs[lane]},
                           judge))
                return true;
        }
    }
    return false;
}

enum class Step { onwards, done, stopped };

/// Visits the node or the leaf where the walk stands.
template <bool ahead>
HWY_INLINE Step advance(Walk& walk, const TriangleTree& tree, const TreeRay& ray,
                        const BoxRay& boxes, Judge& judge) {
    if (walk.current.is_leaf()) {
        for (uint32_t i = 0; i < walk.current.count(); ++i)
            if (test_block(tree.blocks[walk.current.first() + i], ray, judge)) return Step::stopped;
    } else if (descend<ahead>(walk, tree.boxes.nodes, boxes, judge.reach)) {
        return Step::onwards;
    }
    return walk.pop(judge.reach) ? Step::onwards : Step::done;
}

HWY_INLINE bool traverse_one(const TriangleTree& tree, const TreeRay& ray, Judge& judge) {
    Walk walk;
    walk.current = tree.boxes.root;
    if (walk.current.is_nothing()) return false;
    BoxRay boxes;
    boxes.set(ray);
    Step step = Step::onwards;
    while (step == Step::onwards) step = advance<true>(walk, tree, ray, boxes, judge);
    return step == Step::stopped;
}

bool TraverseTriangles(const TriangleTree& tree, const TreeRay& ray, Judge& judge) {
    return traverse_one(tree, ray, judge);
}

void TraverseEach(const TriangleTree& tree, std::span<Wanderer> wanderers) {
    for (Wanderer& wanderer : wanderers)
        wanderer.stopped = traverse_one(tree, *wanderer.ray, *wanderer.judge);
}

/// Asks memory for what the walk will look at next.
HWY_INLINE void prefetch_next(const Walk& walk, const TriangleTree& tree) {
    if (walk.current.is_leaf())
        prefetch(&tree.blocks[walk.current.first()]);
    else
        prefetch(&tree.boxes.nodes[walk.current.index()]);
}

void TraverseWave(const TriangleTree& tree, std::span<Wanderer> wanderers) {
    struct Flight {
        Walk walk;
        BoxRay boxes;
        Wanderer* wanderer;
    };
    if (tree.boxes.root.is_nothing()) return;
    std::array<Flight, 12> flights;
    std::array<uint8_t, 12> places = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};  // those flying first
    size_t next = 0, flying = 0;
    const auto start = [&](Flight& flight) HWY_ATTR {
        flight.wanderer = &wanderers[next++];
        flight.boxes.set(*flight.wanderer->ray);
        flight.walk.current = tree.boxes.root;
        flight.walk.depth = 0;
    };
    while (flying < flights.size() && next < wanderers.size()) start(flights[flying++]);
    while (flying > 0)
        for (size_t i = 0; i < flying; ++i) {
            Flight& flight = flights[places[i]];
            Wanderer& wanderer = *flight.wanderer;
            const Step step =
                advance<false>(flight.walk, tree, *wanderer.ray, flight.boxes, *wanderer.judge);
            if (step == Step::onwards) {
                prefetch_next(flight.walk, tree);
                continue;
            }
            wanderer.stopped = step == Step::stopped;
            if (next < wanderers.size())
                start(flight);
            else
                std::swap(places[i], places[--flying]);
        }
}

bool TraverseBoxes(const BoxTree& tree, const TreeRay& ray, Judge& judge) {
    Walk walk;
    walk.current = tree.root;
    BoxRay boxes;
    boxes.set(ray);
    if (walk.current.is_nothing()) return false;
    for (;;) {
        bool inside = true;
        while (inside && !walk.current.is_leaf())
            inside = descend<true>(walk, tree.nodes, boxes, judge.reach);
        if (inside && judge.visit(walk.current.first(), walk.current.count())) return true;
        if (!walk.pop(judge.reach)) return false;
    }
}

const char* TargetName() { return hwy::TargetName(HWY_TARGET); }

}  // namespace sightline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline {

HWY_EXPORT(TraverseTriangles);
HWY_EXPORT(TraverseEach);
HWY_EXPORT(TraverseBoxes);
HWY_EXPORT(TraverseWave);
HWY_EXPORT(TargetName);

bool traverse(const TriangleTree& tree, const TreeRay& ray, Judge& judge) {
    return HWY_DYNAMIC_DISPATCH(TraverseTriangles)(tree, ray, judge);
}

bool traverse(const BoxTree& tree, const TreeRay& ray, Judge& judge) {
    return HWY_DYNAMIC_DISPATCH(TraverseBoxes)(tree, ray, judge);
}

void traverse_each(const TriangleTree& tree, std::span<Wanderer> wanderers) {
    HWY_DYNAMIC_DISPATCH(TraverseEach)(tree, wanderers);
}

void traverse_wave(const TriangleTree& tree, std::span<Wanderer> wanderers) {
    HWY_DYNAMIC_DISPATCH(TraverseWave)(tree, wanderers);
}

const char* vector_target() { return HWY_DYNAMIC_DISPATCH(TargetName)(); }

}  // namespace sightline
#endif
