#include "lab/atlas/trial.h"

namespace sightline {

double absolute_dot(const Vec3d& a, const Vec3d& b) {
    return std::abs(a.x * b.x) + std::abs(a.y * b.y) + std::abs(a.z * b.z);
}

double angle_between(const Vec3d& a, const Vec3d& b) {
    return std::atan2(cross(a, b).length(), dot(a, b));
}

MeetingPoint::MeetingPoint(const Ray& ray, double at, const Vec3d& unit_normal)
    : t(at), normal(unit_normal) {
    const Vec3d origin(ray.origin), direction(ray.direction), p = origin + direction * t;
    across = std::abs(dot(normal, direction));
    reach = absolute_dot(normal, origin) + std::abs(t) * absolute_dot(normal, direction);
    for (int i = 0; i < 3; ++i) scale = std::max({scale, std::abs(origin[i]), std::abs(p[i])});
}

Measures MeetingPoint::errors(double measured_t) const {
    constexpr double unit = 0x1p-24;
    const double error = std::abs(measured_t - t);
    const auto magnitude = static_cast<float>(std::abs(t));
    const double ulp =
        static_cast<double>(std::nextafter(magnitude, INFINITY)) - static_cast<double>(magnitude);
    Measures result = no_measures;
    const auto set = [&](Measure m, double value) { result[static_cast<size_t>(m)] = value; };
    set(Measure::t_ulps, error / ulp);
    set(Measure::backward, error * across / (scale * 2 * unit));
    set(Measure::stability, error * across / (reach * unit));
    return result;
}

}  // namespace sightline
