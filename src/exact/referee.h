#pragma once
// The last word on which surface of a scene a ray meets first.
#include "core/ray.h"
#include "exact/triangle.h"
#include "scene/scene.h"

#include <compare>
#include <span>
#include <string>
#include <vector>

namespace sightline {

/// A triangle or a shape, named as a Hit names it.
struct SurfaceId {
    uint32_t instance = none, geometry = none, primitive = none;

    auto operator<=>(const SurfaceId&) const = default;
};

inline SurfaceId surface_of(const Hit& hit) { return {hit.instance, hit.geometry, hit.primitive}; }

/// The triangle of that name. `scene` must outlive it.
PlacedTriangle placed_triangle(const Scene& scene, const SurfaceId& id);

/// What a ray meets first, exactly.
struct Truth {
    std::vector<SurfaceId> nearest;  ///< all surfaces at the least t, ascending; empty: a miss
    double t = 0;                    ///< the double nearest to that t
    bool complete = true;            ///< false: an unjudged surface (see Referee) may lie nearer
};

/// One place where a ray crosses or touches a surface.
struct ExactCrossing {
    SurfaceId surface;
    double t;          ///< the nearest double
    int multiplicity;  ///< even: it touches
    bool tied;         ///< at exactly the same t as the crossing before it in the list
};

/// How an engine's answer stands to the truth.
enum class Verdict : uint8_t {
    same,
    tie,              ///< right, and several surfaces lie at exactly that t
    near_tie,         ///< a surface that is crossed a float's ulp of t, or less, behind the nearest
    missed,           ///< nothing, where there is something
    false_hit,        ///< something, where there is nothing
    wrong_primitive,  ///< another surface than the nearest
    undecidable,      ///< none of the truth, but that of a ray with one coordinate one ulp away
    unjudged          ///< see Truth::complete
};
inline constexpr size_t verdicts = 8;
std::string_view name_of(Verdict verdict);

/// Decides by exact arithmetic, filtered by bounded doubles and a conservative tree of boxes.
/// Triangles with a coordinate that is not finite hit nothing, nor do edge-on ones. The surfaces
/// that it cannot judge are those named in exact/shapes.h. Const calls are thread-safe; the
/// calling thread must not flush denormal numbers to zero.
class Referee {
  public:
    /// The scene must outlive the referee. Throws as check_arithmetic. Instances are flattened: 60
    /// bytes per placed triangle.
    explicit Referee(const Scene& scene);

    Truth closest(const Ray& ray) const;
    bool occluded(const Ray& ray) const;

    /// Every crossing, ascending in t.
    std::vector<ExactCrossing> all(const Ray& ray) const;

    /// Compares an engine's nearest hit with the truth. t is not looked at.
    Verdict judge(const Ray& ray, const Hit& hit) const { return judge(ray, closest(ray), hit); }
    /// The same where the ray's truth is known.
    Verdict judge(const Ray& ray, const Truth& truth, const Hit& hit) const;

    /// Compares what an engine says of the segment with the truth: same, missed, false_hit,
    /// undecidable or unjudged.
    Verdict judge_occlusion(const Ray& ray, const Truth& truth, bool blocked) const;

  private:
    /// Children of an inner node are the next one and `second`; a leaf holds items.
    struct Node {
        Box3 box;
        uint32_t second = 0, first = 0, count = 0;
    };

    uint32_t build(std::span<const Box3> boxes, std::span<uint32_t> order, uint32_t first);
    template <class Visit>
    void traverse(const Ray& ray, const double& tmax, const Visit& visit) const;

    const Scene* scene_;
    std::vector<SurfaceId> items_;
    std::vector<Node> nodes_;
};

}  // namespace sightline
