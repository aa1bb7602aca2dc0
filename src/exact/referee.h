#pragma once
// Exact closest hits in a scene, and verdicts on the answers of engines.
#include "core/ray.h"
#include "exact/surface_tree.h"
#include "scene/scene.h"

#include <string>
#include <vector>

namespace sightline {

/// The triangle with that id. `scene` must outlive it.
InstancedTriangle instanced_triangle(const Scene& scene, const SurfaceId& id);

/// The exact closest hit of a ray.
struct Truth {
    std::vector<SurfaceId> nearest;  ///< all surfaces at the least t, ascending; empty: a miss
    double t = 0;                    ///< the double nearest to that t
    bool complete = true;            ///< false: an unjudged surface (see Referee) may lie nearer
};

/// A point at which a ray crosses or touches a surface.
struct ExactCrossing {
    SurfaceId surface;
    double t;          ///< the nearest double
    int multiplicity;  ///< even: it touches
    bool tied;         ///< at exactly the same t as the crossing before it in the list
};

/// The class of an engine's answer after comparison with the truth.
enum class Verdict : uint8_t {
    same,
    tie,        ///< correct, and several surfaces lie at exactly that t
    near_tie,   ///< a surface that the ray crosses at most one float ulp of t behind the nearest
    missed,     ///< no hit, but there is one
    false_hit,  ///< a hit, but there is none
    wrong_primitive,  ///< another surface than the nearest
    wrong_t,          ///< the right surface, but t is off by more than Tolerances::t
    wrong_uv,         ///< likewise, but u or v is off by more than Tolerances::uv
    undecidable,      ///< wrong, but correct for a ray of neighbours_of
    unjudged          ///< see Truth::complete
};
inline constexpr size_t verdicts = 10;
std::string_view name_of(Verdict verdict);

/// Whether the answer is refuted: missed, false_hit or one of the verdicts wrong_….
bool is_wrong(Verdict verdict);

/// The errors that are allowed in a hit, as multiples of the change that moving every number of the
/// ray and of the surface by one float ulp can cause (exact/condition.h).
struct Tolerances {
    double t = 8, uv = 32;
};

/// Exact closest-hit and any-hit queries, behind a filter of bounded doubles and a conservative
/// BVH over triangles and shapes. Triangles with a coordinate that is not finite are never hit, nor
/// are edge-on ones. Shapes without an exact answer (exact/shapes.h) are unjudged. Const calls are
/// thread-safe; the calling thread must not flush denormal numbers to zero.
class Referee {
  public:
    /// The scene must outlive the referee. Throws Error as check_arithmetic does. Takes memory as
    /// SurfaceTree does.
    explicit Referee(const Scene& scene, Tolerances tolerances = {});

    Truth closest(const Ray& ray) const;
    bool occluded(const Ray& ray) const { return occluded(ray, {}); }
    /// By another surface than `except`.
    bool occluded(const Ray& ray, const SurfaceId& except) const;

    /// Every crossing, ascending in t.
    std::vector<ExactCrossing> all(const Ray& ray) const;

    /// Compares an engine's closest hit with the truth.
    Verdict judge(const Ray& ray, const Hit& hit) const { return judge(ray, closest(ray), hit); }
    /// The same for a known truth of the ray. A wrong hit of `source`, the surface that the ray
    /// leaves, is never undecidable: it shows as a dark spot.
    Verdict judge(const Ray& ray, const Truth& truth, const Hit& hit,
                  const SurfaceId& source = {}) const;

    /// Compares an engine's any-hit result with the truth. Returns same, missed, false_hit,
    /// undecidable or unjudged. `source` as above.
    Verdict judge_occlusion(const Ray& ray, const Truth& truth, bool blocked,
                            const SurfaceId& source = {}) const;

  private:
    Verdict judge_numbers(const Ray& ray, const Hit& hit, double exact_t,
                          double least_size = 0) const;
    bool is_right_for_neighbour(const Ray& ray, const Hit& hit) const;
    bool is_near_tie(const Ray& ray, const Truth& truth, const Hit& hit) const;

    const Scene* scene_;
    Tolerances tolerances_;
    SurfaceTree surfaces_;
};

}  // namespace sightline
