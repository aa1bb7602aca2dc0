#pragma once
// A plane below what a picture shows, which is no part of the scene.
#include "core/ray.h"
#include "render/settings.h"
#include "shade/environment.h"
#include "shade/lights.h"

#include <memory>

namespace sightline {

// One rule gives what a ray sees that passes the ground from above at the point p: what it would
// see without shadows there, times the share of the light that reaches p,
//
//   S(p) = 1 − Σ E_i(p) (1 − V_i(p)) / Σ E_i(p)
//
// over the environment and the punctual lights i, with the irradiance E_i that falls on the ground
// when nothing is in the way and the transmittance V_i of what is. Without shadows, a ray sees
//
//   shadow      what it would see without the ground: the background or the environment;
//   matte       albedo · Σ E_i(p) / π;
//   cyclorama   near the scene the same with the background's colour as albedo, kept near that
//               colour; at a distance that colour; between, a mixture.
//
// S is exactly 1 where nothing is in the way, whatever the samples of the environment. A matte
// ground and, near the scene, a cyclorama also send on the light of emissive surfaces: albedo / π
// times the irradiance of the part that is not shadowed, by a sample of an emitter.

/// The ground of a picture, in the scene's frame. Seen from below it is not there.
class Ground {
  public:
    /// `environment` may be null.
    Ground(const Scene& scene, const RenderSettings& settings, const Environment* environment);

    bool exists() const { return settings_.kind != GroundKind::nothing; }
    /// Whether it has a colour of its own.
    bool is_surface() const {
        return settings_.kind == GroundKind::matte || settings_.kind == GroundKind::cyclorama;
    }
    bool is_cyclorama() const { return settings_.kind == GroundKind::cyclorama; }

    /// The distance at which the ray passes the ground from above, or infinity.
    float distance(const Ray& ray) const {
        const bool meets = ray.origin.y > settings_.height && ray.direction.y < 0;
        return meets ? line_distance(ray) : std::numeric_limits<float>::infinity();
    }
    /// Whether it holds off a light at this distance.
    bool blocks(const Vec3& from, const LightSample& light) const {
        return exists() && distance({from, 0, light.wi}) < light.distance;
    }
    /// Where the ray's line, not horizontal, passes it.
    float line_distance(const Ray& ray) const {
        return (settings_.height - ray.origin.y) / ray.direction.y;
    }
    /// The point of the ground at this distance.
    Vec3 point(const Ray& ray, float distance) const {
        return {ray.origin.x + distance * ray.direction.x, settings_.height,
                ray.origin.z + distance * ray.direction.z};
    }

    /// What falls on the point of lights and environment if nothing is in the way.
    Vec3 irradiance(const Vec3& p) const;
    /// What a surface sends from there if nothing is in the way of the light.
    Vec3 radiance(const Vec3& p) const;
    /// The part of the light of emitters that a surface there sends on.
    Vec3 albedo(const Vec3& p) const;
    /// The part of light that it mirrors from a direction at this cosine to the vertical.
    float reflectance(float cosine) const;
    /// Whether it mirrors what stands on it.
    bool mirrors() const { return settings_.mirror > 0; }
    /// Whether a ray from the ground in this direction may meet the scene.
    bool may_meet_scene(const Vec3& origin, const Vec3& direction) const;

    /// Samples the light of the environment by what of it falls on the ground; or nullptr.
    const Environment* sky() const { return sky_.get(); }
    /// The environment with what the ground, if it is a surface, sends in place of its lower half;
    /// or nullptr: the environment as it is.
    const Environment* environment() const { return environment_.get(); }

  private:
    void add_sky(const Environment& environment);
    /// Of a cyclorama at a point: 0 near the scene, 1 where it is the background.
    float background_share(const Vec3& p) const;

    const Scene& scene_;
    GroundSettings settings_;
    std::unique_ptr<const Environment> sky_, environment_;
    Vec3 sky_irradiance_{0, 0, 0};
    Box3 bounds_;  // of the scene; empty: endless
    Vec3 centre_{0, 0, 0};
    float near_ = 0, far_ = 0;  // where a cyclorama begins to become the background, and has
};

}  // namespace sightline
