#pragma once
#include "core/ray.h"
#include "scene/scene.h"

#include <optional>

namespace sightline {

/// Light arriving at a point from one direction.
struct LightSample {
    Vec3 wi;         ///< unit, towards the light
    float distance;  ///< to it; infinite for directional lights and the environment
    Vec3 radiance;   ///< of an area; for a punctual light the irradiance on a surface facing it
    float pdf;       ///< per solid angle; 0 for a punctual light
};

/// Light of a punctual light at `p`, with range and cone falloff as KHR_lights_punctual
/// recommends; nothing where it does not reach.
std::optional<LightSample> sample_punctual(const Light& light, const Vec3& p);

/// Emissive triangles as area lights, picked by power.
class AreaLights {
  public:
    explicit AreaLights(const Scene& scene);

    bool empty() const { return emitters_.empty(); }
    size_t count() const { return emitters_.size(); }

    /// A point on an emitter seen from `p`; `u` on the triangle, `pick` chooses it.
    /// The radiance is the material's emissive factor (times the texture's mean).
    std::optional<LightSample> sample(const Vec3& p, Vec2 u, float pick) const;

    /// Density with which sample() would have taken the direction of this ray that hit an emitter.
    float pdf(const Ray& ray, const Hit& hit) const;

  private:
    struct Emitter {
        Vec3 a, b, c;  // world space
        Vec3 radiance;
        float area, probability;
        bool double_sided;
    };
    const Scene& scene_;
    std::vector<Emitter> emitters_;
    std::vector<float> cdf_;
    std::vector<std::vector<uint32_t>> first_;  // [instance][mesh in group] → first emitter or none
};

}  // namespace sightline
