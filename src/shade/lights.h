#pragma once
#include "core/ray.h"
#include "scene/scene.h"
#include "shade/surface.h"

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
    /// Takes the triangles whose mean emission is not black, the million strongest at most.
    /// Both must outlive it.
    AreaLights(const Scene& scene, const Surfaces& surfaces);

    bool empty() const { return emitters_.empty(); }
    size_t count() const { return emitters_.size(); }
    /// Sum of π · area · luminance over all emitting sides, in the scene's units.
    float power() const { return power_; }

    /// A point on an emitter seen from `p`; `u` on the triangle, `pick` chooses it.
    std::optional<LightSample> sample(const Vec3& p, Vec2 u, float pick) const;

    /// Density with which sample() would have taken the direction of this ray that hit an emitter;
    /// 0 where the hit is on none.
    float pdf(const Ray& ray, const Hit& hit) const;

  private:
    struct Emitter {
        Vec3 a, ab, ac;  // world space: a corner and two edges
        Vec3 normal;     // unit; the side that emits
        float density;   // probability of being picked over area
        uint32_t instance, geometry, primitive;
        bool double_sided;
    };
    void add_mesh(uint32_t instance, uint32_t geometry, std::vector<float>& powers);
    void keep_strongest(std::vector<float>& powers);
    const Emitter* find(const Hit& hit) const;

    const Scene& scene_;
    const Surfaces& surfaces_;
    std::vector<Emitter> emitters_;  // by instance, geometry, primitive
    std::vector<float> cdf_;
    std::vector<uint32_t> guide_;  // where each of as many equal parts of [0,1] begins in cdf_
    float power_ = 0;
};

}  // namespace sightline
