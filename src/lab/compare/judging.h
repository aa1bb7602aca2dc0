#pragma once
// One answer against the truth.
#include "lab/compare/compare.h"

namespace sightline {

/// The truth of any ray: an invalid one hits nothing, by definition.
Truth truth_of(const Referee& referee, const Ray& ray);

/// The referee's verdict, also on rays that are not valid.
Verdict verdict_of(const Referee& referee, const Ray& ray, const Truth& truth, const Hit& hit);
Verdict occlusion_verdict_of(const Referee& referee, const Ray& ray, const Truth& truth,
                             bool blocked);

/// The hit that the truth is, rounded to floats; none where there is none.
Hit exact_hit_of(const Scene& scene, const Ray& ray, const Truth& truth, const SurfaceId& surface);

/// Degrees between the normals that a surface has at two hits of a ray, as the renderer sees them.
double normal_angle(const Scene& scene, const Ray& ray, const Hit& a, const Hit& b);

}  // namespace sightline
