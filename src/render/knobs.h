#pragma once
#include "scene/scene.h"

namespace sightline {

/// What of a scene's triangles makes them hard to meet, as the atlas' families measure it.
struct TriangleKnobs {
    /// Two triangles share an edge, between which a ray can slip. Then the knobs below are those
    /// of the triangles up to there, since nothing else matters any more.
    bool shared_edges = false;
    /// Largest coordinate, of the eye too, against the shortest edge: the knob of T1 and T5.
    double reach_per_edge = 0;
    /// The same against the smallest height of a triangle: the knob of T2.
    double reach_per_width = 0;
    size_t triangles = 0;  ///< looked at
};

/// Looks at the meshes as they are placed; `eye` in world space. Edges count as shared where the
/// ends are at equal places; in meshes that are instanced, or of more than 200,000 triangles, they
/// are taken to be.
TriangleKnobs find_triangle_knobs(const Scene& scene, const Vec3& eye);

}  // namespace sightline
