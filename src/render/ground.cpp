#include "render/ground.h"

#include "scene/shape_bounds.h"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

/// A cyclorama is so many times as bright as the background at most, or as dark: more would be
/// a pool of light before a wall.
constexpr float sweep_contrast = 1.15f;

/// Columns of the copies of an environment: enough for the cosine to vary little from row to row,
/// and for the sky no more than a soft shadow shows.
constexpr int least_columns = 256, most_sky_columns = 2048;

bool has_endless_shapes(const Scene& scene) {
    return std::ranges::any_of(scene.instances, [&](const Instance& instance) {
        return std::ranges::any_of(scene.groups[instance.group].shapes,
                                   [&](uint32_t shape) { return is_endless(scene.shapes[shape]); });
    });
}

/// The bounds with room for the rounding of rays that touch them.
Box3 widened(Box3 box) {
    const Vec3 room(box.size().length() * 1e-5f);
    box.min -= room;
    box.max += room;
    return box;
}

}  // namespace

Ground::Ground(const Scene& scene, const RenderSettings& settings, const Environment* environment)
    : scene_(scene), settings_(settings.ground) {
    if (!exists()) return;
    if (!scene.bounds.isEmpty()) {
        if (!has_endless_shapes(scene)) bounds_ = widened(scene.bounds);
        centre_ = scene.bounds.center();
        const float radius = scene.bounds.size().length() / 2;
        near_ = radius;
        far_ = 5 * radius;
    }
    if (environment && settings.integrator == Integrator::whitted) add_sky(*environment);
}

void Ground::add_sky(const Environment& environment) {
    sky_ = std::make_unique<Environment>(environment.changed(
        [](float y, const Vec3& radiance) { return radiance * std::max(y, 0.0f); },
        std::clamp(environment.columns(), least_columns, most_sky_columns)));
    sky_irradiance_ = sky_->integral();
    if (!is_surface()) return;
    const Vec3 sent = settings_.color * sky_irradiance_ * (1 / pi);
    environment_ = std::make_unique<Environment>(
        environment.changed([&](float y, const Vec3& radiance) { return y < 0 ? sent : radiance; },
                            std::max(environment.columns(), least_columns)));
}

Vec3 Ground::irradiance(const Vec3& p) const {
    Vec3 sum = sky_irradiance_;
    for (const Light& light : scene_.lights)
        if (const auto sample = sample_punctual(light, p))
            sum += sample->radiance * std::max(sample->wi.y, 0.0f);
    return sum;
}

Vec3 Ground::radiance(const Vec3& p) const {
    const Vec3 light = irradiance(p) * (1 / pi);
    if (!is_cyclorama()) return settings_.color * light;
    Vec3 lit(0, 0, 0);
    for (int c = 0; c < 3; ++c)
        lit[c] = settings_.color[c] * std::clamp(light[c], 1 / sweep_contrast, sweep_contrast);
    const float share = background_share(p);
    return lit * (1 - share) + settings_.color * share;
}

float Ground::background_share(const Vec3& p) const {
    const float distance = std::hypot(p.x - centre_.x, p.z - centre_.z);
    const float t = far_ > near_ ? std::clamp((distance - near_) / (far_ - near_), 0.0f, 1.0f) : 1;
    return t * t * (3 - 2 * t);
}

Vec3 Ground::albedo(const Vec3& p) const {
    return is_cyclorama() ? settings_.color * (1 - background_share(p)) : settings_.color;
}

// Schlick's approximation.
float Ground::reflectance(float cosine) const {
    return settings_.mirror + (1 - settings_.mirror) * std::pow(1 - cosine, 5.0f);
}

bool Ground::may_meet_scene(const Vec3& origin, const Vec3& direction) const {
    if (bounds_.isEmpty()) return true;
    float near = 0, far = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0) {
            if (origin[axis] < bounds_.min[axis] || origin[axis] > bounds_.max[axis]) return false;
            continue;
        }
        const float a = (bounds_.min[axis] - origin[axis]) / direction[axis];
        const float b = (bounds_.max[axis] - origin[axis]) / direction[axis];
        near = std::max(near, std::min(a, b));
        far = std::min(far, std::max(a, b));
    }
    return near <= far;
}

}  // namespace sightline
