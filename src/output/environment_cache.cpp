#include "output/environment_cache.h"

#include "core/error.h"
#include "core/hash.h"
#include "shade/studio.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sightline {

std::string choose_environment(const LightOptions& options, const Scene& scene) {
    if (!options.env.empty()) return options.env;
    return scene.background || lamp_brightness(scene) >= dark_lamps ? "none" : "studio";
}

bool is_environment_file(const std::string& env) {
    return !env.empty() && env != "none" &&
           std::ranges::find(light_names(), env) == light_names().end();
}

std::string light_problem(const RenderCommand& command) {
    const LightOptions& light = command.light;
    if (light.env_blur == 0) return "";
    const bool seen = light.background ? light.background == Background::environment
                                       : is_environment_file(light.env) &&
                                             command.ground.kind != GroundKind::cyclorama;
    return seen ? ""
                : "--env-blur is for an environment that the camera sees: give --env FILE, or "
                  "--background env with a built-in light";
}

double lamp_brightness(const Scene& scene) {
    const Vec3 centre = scene.bounds.isEmpty() ? Vec3(0, 0, 0) : scene.bounds.center();
    const double radius = scene.bounds.isEmpty() ? 0 : double(scene.bounds.size().length()) / 2;
    double sum = 0;
    for (const Light& light : scene.lights) {
        const double power = double(light.intensity) * double(max_component(light.color));
        if (light.kind == LightKind::directional) {
            sum += power;
            continue;
        }
        const Vec3 to_centre = centre - light.position;
        const double from_centre = double(to_centre.length());
        // A lamp within the scene lights what is a tenth of the radius away.
        const double distance = std::max({from_centre - radius, radius / 10, 1e-9});
        if (distance > double(light.range)) continue;
        if (light.kind == LightKind::spot && from_centre > radius) {
            const double angle = std::acos(
                std::clamp(double(dot(to_centre, light.direction)) / from_centre, -1.0, 1.0));
            if (angle - std::asin(radius / from_centre) > double(light.outer_cone_angle)) continue;
        }
        sum += power / (distance * distance);
    }
    return sum / M_PI;
}

uint64_t hash_environment(const std::string& path, const ImageLimits& limits) {
    try {
        return hash_shared_file(path, limits.max_file_bytes);
    } catch (const LimitError& error) {
        throw LimitError(std::string(error.what()) + " (--max-env-bytes)");
    }
}

std::shared_ptr<const Environment> EnvironmentCache::get(const LightOptions& light,
                                                         const std::string& env,
                                                         const ImageLimits& limits) {
    const auto make_key = [&] {
        return fmt::format("{} {} {} {} {}", light.env_rotation, light.env_brightness,
                           limits.max_pixels,
                           is_environment_file(env) ? hash_environment(env, limits) : 0, env);
    };
    const std::lock_guard lock(mutex_);
    const std::string key = make_key();
    if (key == key_) return environment_;
    const Image picture = is_environment_file(env) ? read_image(env, limits) : light_image(env);
    key_.clear();
    environment_ =
        std::make_shared<Environment>(picture, light.env_rotation * pi / 180, light.env_brightness);
    if (make_key() == key) key_ = key;  // the file has not changed while it was read
    return environment_;
}

}  // namespace sightline
