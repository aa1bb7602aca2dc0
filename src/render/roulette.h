#pragma once
#include "render/settings.h"

namespace sightline {

/// An upper bound of the radiance that a ray can find: infinite if an environment, whose content is
/// not looked at, or punctual lights, whose irradiance has no bound, light the scene; at least 1.
float brightest_radiance(const Scene& scene, const RenderSettings& settings, bool environment);

/// Russian roulette over the rays of small weight (Arvo and Kirk 1990, "Particle Transport and
/// Image Synthesis"): what could be seen is dropped by chance alone, so that means stay right.
class Roulette {
  public:
    Roulette(const Scene& scene, const RenderSettings& settings, bool environment);

    /// The probability with which a ray of this throughput is to be traced. 0 only if it cannot
    /// bring as much as the cutoff.
    float survival(const Vec3& throughput) const { return survival(throughput, cutoff_); }

    /// The same with a limit above the cutoff: rays of a throughput below `faint` are traced so
    /// rarely that a survivor counts for twice `faint`, unless emitters are bright. That is seen as
    /// noise.
    float survival(const Vec3& throughput, float faint) const;

  private:
    float cutoff_;
    float brightest_;  // brightest_radiance
    float emitters_;   // the largest radiance of an emissive surface
};

}  // namespace sightline
