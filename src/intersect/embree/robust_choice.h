#pragma once
// Whether a scene needs Embree's ROBUST mode.
#include "intersect/embree/build_quality.h"

namespace sightline {

/// Embree's mode and build quality for a scene, and the figures that they are based on.
struct RobustChoice {
    bool robust;
    std::string reason;
    BuildQuality quality = BuildQuality::medium;
    OverlapStats overlap = {};  ///< the reason for the quality; only computed in the default mode
};

/// Chooses ROBUST unless breakdown.json shows that the default mode does not fail anywhere near
/// this scene: it has only baked triangles, no two share an edge, and the knob of the atlas that
/// measures thin triangles is well below its first failure. `eye` is in world space. The quality is
/// that of choose_build_quality in the default mode; ROBUST BVHs have no spatial splits.
RobustChoice choose_robust(const Scene& scene, const Vec3& eye);

/// The properties of a scene's triangles that the atlas' families vary.
struct TriangleStats {
    /// Two triangles share an edge, where a ray can slip through. Then the ratios below only cover
    /// the triangles up to the first shared edge.
    bool shared_edges = false;
    /// The largest coordinate, of the eye too, divided by the shortest edge: the knob of T1 and T5.
    double max_coordinate_over_min_edge = 0;
    /// The same divided by the smallest height of a triangle: the knob of T2.
    double max_coordinate_over_min_height = 0;
    size_t triangles = 0;  ///< examined
};

/// Edges are shared if their ends have equal positions. Instanced meshes, and scenes of more than
/// 200,000 triangles, count as having shared edges.
TriangleStats triangle_stats(const Scene& scene, const Vec3& eye);

/// The knob value up to which a method gave no wrong answer in a family of the atlas, according to
/// breakdown.json (docs/atlas.md); 0 if that was not measured. Knobs grow by up to 100 from value
/// to value, so a method that failed counts as safe up to a hundredth of its first failure.
double max_safe_value(const std::string& family, const std::string& method);

/// The smallest knob value at which the method gave a wrong answer; infinity if it never did.
double first_failing_value(const std::string& family, const std::string& method);

}  // namespace sightline
