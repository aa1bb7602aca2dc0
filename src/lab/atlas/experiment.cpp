#include "lab/atlas/experiment.h"

namespace sightline {

MethodAnswer answer_of(bool hit, double t, int count) {
    MethodAnswer answer;
    if (hit) answer.hit.geometry = 0;
    answer.t = t;
    answer.count = count;
    return answer;
}

Vec3d point_at(const Ray& ray, double t) { return Vec3d(ray.origin) + Vec3d(ray.direction) * t; }

SurfaceCrossing::SurfaceCrossing(const Ray& ray, double exact_t, const Vec3d& unit_normal)
    : t(exact_t), normal(unit_normal) {
    const Vec3d origin(ray.origin), direction(ray.direction), p = origin + direction * t;
    normal_speed = std::abs(dot(normal, direction));
    input_sensitivity =
        absolute_dot(normal, origin) + std::abs(t) * absolute_dot(normal, direction);
    for (int i = 0; i < 3; ++i)
        max_coordinate = std::max({max_coordinate, std::abs(origin[i]), std::abs(p[i])});
}

Measures SurfaceCrossing::measure(double measured_t) const {
    constexpr double half_ulp = 0x1p-24;  // of 1
    const double error = std::abs(measured_t - t);
    const auto magnitude = static_cast<float>(std::abs(t));
    const double ulp =
        static_cast<double>(std::nextafter(magnitude, INFINITY)) - static_cast<double>(magnitude);
    return {.t_ulps = error / ulp,
            .backward = error * normal_speed / (max_coordinate * 2 * half_ulp),
            .stability = error * normal_speed / (input_sensitivity * half_ulp)};
}

Measures SurfaceCrossing::measure(double measured_t, const Vec3d& measured_normal) const {
    Measures measures = measure(measured_t);
    measures.normal_angle =  // accurate for small angles, too
        std::atan2(cross(normal, measured_normal).length(), dot(normal, measured_normal));
    return measures;
}

}  // namespace sightline
