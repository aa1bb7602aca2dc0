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
    Vec3 radiance;   ///< or, for a punctual light, the irradiance on a surface that faces it
    float pdf;       ///< per solid angle; 0 for a punctual light
};

/// The light that arrives at `p` from a punctual light, with the falloff of range and cone that
/// KHR_lights_punctual recommends; nothing outside its range or cone.
std::optional<LightSample> sample_punctual(const Light& light, const Vec3& p);

/// Emissive triangles as area lights, picked by power.
class AreaLights {
  public:
    /// Uses the triangles whose mean emission is not black, at most the million with most power.
    /// Scene and surfaces must outlive it.
    AreaLights(const Scene& scene, const Surfaces& surfaces);

    bool empty() const { return emitters_.empty(); }
    size_t count() const { return emitters_.size(); }
    /// Sum of π · area · luminance over all emitting sides, in the scene's units.
    float power() const { return power_; }

    /// Samples a direction from `p` to an emitter: `pick` in [0,1) chooses the triangle, `u` the
    /// point on it. Nothing if that faces away.
    std::optional<LightSample> sample(const Vec3& p, Vec2 u, float pick) const;

    /// Pdf with which sample(ray.origin, …) picks the direction of a ray that hit an emitter, per
    /// solid angle; 0 if the hit is on no emitter.
    float pdf(const Ray& ray, const Hit& hit) const;

  private:
    struct Emitter {
        Vec3 a, ab, ac;  // world space: a corner and two edges
        Vec3 normal;     // unit; the side that emits
        float density;   // probability of this triangle over its area
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
    std::vector<uint32_t> guide_;  // for i: the first emitter whose cdf_ may exceed i / count
    float power_ = 0;
};

}  // namespace sightline
