#include "lab/compare/judging.h"

#include "intersect/ray_rules.h"
#include "lab/tally.h"
#include "shade/hit_geometry.h"

#include <algorithm>

namespace sightline {

Truth find_truth(const Referee& referee, const Ray& ray) {
    return is_valid(ray) ? referee.closest(ray) : Truth{};
}

Verdict judge_hit(const Referee& referee, const RecordedRay& recorded, const Truth& truth,
                  const Hit& hit) {
    const Ray& ray = recorded.ray;
    if (!is_valid(ray)) return hit ? Verdict::false_hit : Verdict::same;
    const bool assumed =
        recorded.source == SurfaceId() && recorded.kind != RayKind::camera && is_self_hit(ray, hit);
    return referee.judge(ray, truth, hit, assumed ? surface_of(hit) : recorded.source);
}

Verdict judge_occlusion(const Referee& referee, const RecordedRay& recorded, const Truth& truth,
                        bool occluded) {
    Ray ray = recorded.ray;
    if (!is_valid(ray)) return occluded ? Verdict::false_hit : Verdict::same;
    // A ray that nothing blocks may only be excused by what lies beyond a self-hit.
    if (occluded && truth.nearest.empty() && recorded.source == SurfaceId())
        ray.tnear = std::max(ray.tnear, self_hit_reach(ray));
    if (!is_valid(ray)) return Verdict::false_hit;
    return referee.judge_occlusion(ray, truth, occluded, recorded.source);
}

Hit compute_exact_hit(const Scene& scene, const Ray& ray, const Truth& truth,
                      const SurfaceId& surface) {
    Hit hit{
        static_cast<float>(truth.t), 0, 0, surface.primitive, surface.geometry, surface.instance};
    if (!scene.is_mesh(surface.geometry)) return hit;
    const PlaneHit plane = plane_hit(ray, instanced_triangle(scene, surface));
    hit.u = static_cast<float>(plane.u);
    hit.v = static_cast<float>(plane.v);
    return hit;
}

double normal_angle(const Scene& scene, const Ray& ray, const Hit& a, const Hit& b) {
    const Vec3d m(hit_geometry(scene, a, &ray, false).normal),
        n(hit_geometry(scene, b, &ray, false).normal);
    const double angle = std::atan2(cross(m, n).length(), dot(m, n));
    return angle * 180 / 3.14159265358979323846;
}

}  // namespace sightline
