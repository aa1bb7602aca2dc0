#include "output/environment_cache.h"

#include "core/error.h"
#include "core/hash.h"
#include "shade/studio.h"

#include <fmt/format.h>

namespace sightline {

std::string choose_environment(const LightOptions& options, const Scene& scene) {
    if (!options.env.empty()) return options.env;
    return scene.lights.empty() && !scene.background ? "studio" : "none";
}

bool is_environment_file(const std::string& env) {
    return !env.empty() && env != "studio" && env != "none";
}

uint64_t hash_environment(const std::string& path, const ImageLimits& limits) {
    try {
        return hash_shared_file(path, limits.max_file_bytes);
    } catch (const LimitError& error) {
        throw LimitError(std::string(error.what()) + " (--max-env-bytes)");
    }
}

std::shared_ptr<const Environment> EnvironmentCache::get(const std::string& env,
                                                         float rotation_degrees,
                                                         const ImageLimits& limits) {
    const auto make_key = [&] {
        return fmt::format("{} {} {} {}", rotation_degrees, limits.max_pixels,
                           is_environment_file(env) ? hash_environment(env, limits) : 0, env);
    };
    const std::lock_guard lock(mutex_);
    const std::string key = make_key();
    if (key == key_) return environment_;
    const Image picture = is_environment_file(env) ? read_image(env, limits) : studio_image();
    key_.clear();
    environment_ = std::make_shared<Environment>(picture, rotation_degrees * pi / 180);
    if (make_key() == key) key_ = key;  // the file has not changed while it was read
    return environment_;
}

}  // namespace sightline
