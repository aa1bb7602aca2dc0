#pragma once
#include "render/ground_shadows.h"
#include "shade/bsdf.h"

namespace sightline {

/// The power heuristic with beta = 2 (Veach & Guibas 1995).
inline float mis_weight(float pdf, float other_pdf) {
    const float a = pdf * pdf, b = other_pdf * other_pdf;
    return a > 0 ? a / (a + b) : 0;
}

/// How the rough lobes of a surface are estimated.
enum class GlossyEstimator {
    lights_only,          ///< no ray samples them: light sampling has weight 1
    lights_and_rays,      ///< light sampling and secondary rays share them by MIS
    lights_and_last_rays  ///< the same at the last bounce, where rays cross all that transmits
};

/// A surface that light arrives at, and the path from there to the camera.
struct LitVertex {
    const Bsdf& bsdf;
    GlossyEstimator glossy;
    Vec3 throughput;  ///< of the path up to the surface
    uint32_t slot;    ///< of its camera sample
    const MediumStack& media;
};

/// Random points in [0,1)² for the lights, and the environment's sample, for one surface.
struct LightSamples {
    const EnvironmentSample* environment;  ///< nullptr: the environment is not sampled
    Vec2 emitter, which_emitter;
};

/// The light that reaches the surfaces of a wave from punctual lights and from samples of the
/// environment and of emissive triangles: Lp, Ld and the first sum of Lg in render/wave_tracer.h.
class DirectLighting {
  public:
    explicit DirectLighting(const RenderContext& context)
        : context_(context), punctual_shadows_(context), sampled_shadows_(context) {}

    void clear() { punctual_shadows_.clear(), sampled_shadows_.clear(); }

    /// Samples the lights for one surface and keeps their shadow rays.
    void add(const LitVertex& vertex, const LightSamples& samples, SampleBuffer& buffer);

    /// Traces the shadow rays and adds to the samples what arrives. `coherence`: of rays to
    /// punctual lights. `ground` takes what comes from there.
    void trace(Coherence coherence, GroundShadows& ground, SampleBuffer& buffer);

  private:
    void add_punctual(const LitVertex& vertex, const SampleBuffer& buffer);
    Vec3 light_from(const LitVertex& vertex, const EnvironmentSample& sample) const;
    void add_sampled(const LitVertex& vertex, const LightSample& light, uint16_t light_group);

    const RenderContext& context_;
    ShadowRays punctual_shadows_, sampled_shadows_;
};

}  // namespace sightline
