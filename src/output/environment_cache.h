#pragma once
#include "output/options.h"
#include "shade/environment.h"

#include <memory>
#include <mutex>

namespace sightline {

/// The environment that lights the scene, as LightOptions::env has it: the given one, else none if
/// the file has a background or lamps that light it, else the studio.
std::string choose_environment(const LightOptions& options, const Scene& scene);

/// What is wrong with the command's light; "" if nothing is.
std::string light_problem(const RenderCommand& command);

/// Whether `env` is a path, and not empty, "none" or a built-in light.
bool is_environment_file(const std::string& env);

/// The radiance of a white diffuse surface that faces all of the file's lamps, placed where each
/// comes nearest to the sphere about the scene's bounds: no surface of the scene is brighter by
/// lamps alone, but for highlights.
double lamp_brightness(const Scene& scene);

/// Lamps whose lamp_brightness is below this leave the scene dark: 48 of 255 on a display.
inline constexpr double dark_lamps = 0.03;

/// The hash of an environment's file, which is read in pieces, and again only if it has changed.
/// Throws Error, LimitError if it is larger than the limit.
uint64_t hash_environment(const std::string& path, const ImageLimits& limits);

/// Keeps the last environment: preparing one costs as much as rendering a small picture, and a
/// batch lights many assets alike.
class EnvironmentCache {
  public:
    /// `env`: a path or a built-in light, with the rotation and brightness of `light`. Reads the
    /// file again if it, or an option, has changed. Thread-safe. Throws Error.
    std::shared_ptr<const Environment> get(const LightOptions& light, const std::string& env,
                                           const ImageLimits& limits);

  private:
    std::mutex mutex_;
    std::string key_;
    std::shared_ptr<const Environment> environment_;
};

}  // namespace sightline
