#pragma once
// The last word on which surface of a scene a ray meets first.
#include "core/ray.h"
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

/// How an engine's answer stands to the truth. `undecidable`: it is not the truth, but it is that
/// of a ray with one coordinate moved by one float ulp. `unjudged`: see Truth::complete.
enum class Verdict : uint8_t {
    same,
    tie,
    missed,
    false_hit,
    wrong_primitive,
    undecidable,
    unjudged
};
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
    Verdict judge(const Ray& ray, const Hit& hit) const;

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
