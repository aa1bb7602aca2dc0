#include "lab/compare/judging.h"

#include "intersect/ray_rules.h"
#include "shade/hit_geometry.h"

#include <algorithm>

namespace sightline {

Truth find_truth(const Referee& referee, const Ray& ray) {
    return is_valid(ray) ? referee.closest(ray) : Truth{};
}

Verdict judge_hit(const Referee& referee, const Ray& ray, const Truth& truth, const Hit& hit) {
    if (!is_valid(ray)) return hit ? Verdict::false_hit : Verdict::same;
    return referee.judge(ray, truth, hit);
}

Verdict judge_occlusion(const Referee& referee, const Ray& ray, const Truth& truth, bool occluded) {
    if (!is_valid(ray)) return occluded ? Verdict::false_hit : Verdict::same;
    return referee.judge_occlusion(ray, truth, occluded);
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
