#pragma once
#include "core/ray.h"
#include "scene/scene.h"
#include "shade/emissive_mesh.h"

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

/// Emissive triangles as area lights: points on them are sampled by estimated power.
class AreaLights {
  public:
    /// Uses every mesh that emits, or might where its textures shine. Estimates on `threads`
    /// threads (0: all). Scene and surfaces must outlive it.
    AreaLights(const Scene& scene, const Surfaces& surfaces, unsigned threads = 0);

    bool empty() const { return emitters_.empty(); }
    /// The number of triangles that sample() may pick.
    uint64_t count() const;
    /// Estimated sum of π · area · luminance over all emitting sides, in the scene's units: of what
    /// covers, where materials are cut out or transparent.
    double power() const { return power_; }

    /// Samples a direction from `p` to an emitter: `pick` in [0,1)² chooses the part of it, `u` in
    /// [0,1)² the point there. Nothing if that faces away.
    std::optional<LightSample> sample(const Vec3& p, Vec2 u, Vec2 pick) const;

    /// The emitter that a ray has hit: what sample(ray.origin, …) returns if it picks that point.
    /// Nothing if the hit is on no emitter, or on a side that does not shine.
    std::optional<LightSample> at(const Ray& ray, const Hit& hit) const;

  private:
    struct Emitter {  // a mesh in an instance
        uint32_t instance, geometry;
        uint32_t mesh;  // into meshes_
        bool double_sided;
    };
    void add_emitter(uint32_t instance, uint32_t geometry, unsigned threads);
    void prepare_meshes(unsigned threads);
    void keep_emitters_with_weight();
    EmissiveMesh::Integral integral(const Emitter& emitter) const;
    const Emitter* find(const Hit& hit) const;
    std::optional<LightSample> light(const Emitter& emitter, const Hit& hit, const HitGeometry& g,
                                     const Vec3& wi, float distance) const;

    const Scene& scene_;
    const Surfaces& surfaces_;
    std::vector<EmissiveMesh> meshes_;
    std::vector<uint32_t> mesh_of_geometry_;  // into meshes_, or none
    std::vector<Emitter> emitters_;           // by instance, geometry
    DiscreteDistribution pick_;               // of emitters_
    double power_ = 0;
};

}  // namespace sightline
