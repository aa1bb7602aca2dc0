#pragma once
// Verdicts and errors of single answers.
#include "exact/referee.h"
#include "intersect/ray_file.h"

namespace sightline {

/// The exact closest hits; none for an invalid ray, by definition.
Truth find_truth(const Referee& referee, const Ray& ray);

/// The referee's verdict on the answer to a closest-hit or any-hit query, also for invalid rays.
/// A hit of the surface that the ray leaves is no excusable one; where the record does not name
/// that surface, a hit near the origin is taken for one (is_self_hit).
Verdict judge_hit(const Referee& referee, const RecordedRay& ray, const Truth& truth,
                  const Hit& hit);
Verdict judge_occlusion(const Referee& referee, const RecordedRay& ray, const Truth& truth,
                        bool occluded);

/// The exact hit on `surface`, one of the truth's, rounded to floats.
Hit compute_exact_hit(const Scene& scene, const Ray& ray, const Truth& truth,
                      const SurfaceId& surface);

/// Degrees between the interpolated normals at two hits of a ray.
double normal_angle(const Scene& scene, const Ray& ray, const Hit& a, const Hit& b);

}  // namespace sightline
