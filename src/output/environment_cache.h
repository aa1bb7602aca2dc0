#pragma once
#include "output/options.h"
#include "shade/environment.h"

#include <memory>
#include <mutex>

namespace sightline {

/// The environment that lights the scene, as LightOptions::env has it: the given one, else the
/// studio if the file has neither a punctual light nor a background.
std::string choose_environment(const LightOptions& options, const Scene& scene);

/// Whether `env` is a path, and not empty, "studio" or "none".
bool is_environment_file(const std::string& env);

/// The hash of an environment's file, which is read in pieces, and again only if it has changed.
/// Throws Error, LimitError if it is larger than the limit.
uint64_t hash_environment(const std::string& path, const ImageLimits& limits);

/// Keeps the last environment: preparing one costs as much as rendering a small picture, and a
/// batch lights many assets alike.
class EnvironmentCache {
  public:
    /// `env`: a path or "studio". Reads the file again if it, or an option, has changed.
    /// Thread-safe. Throws Error.
    std::shared_ptr<const Environment> get(const std::string& env, float rotation_degrees,
                                           const ImageLimits& limits);

  private:
    std::mutex mutex_;
    std::string key_;
    std::shared_ptr<const Environment> environment_;
};

}  // namespace sightline
