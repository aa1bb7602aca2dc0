#pragma once
#include "render/shadow_rays.h"

namespace sightline {

/// Where a sample keeps what it sees.
enum class SeenAs {
    radiance,    ///< Sample::radiance
    shown,       ///< the same and Sample::shown
    transparent  ///< Sample::through and alpha
};

/// What a sample sees on the ground, added to it as if there were no shadow.
struct GroundView {
    uint32_t slot;
    uint32_t stream;  ///< seed of random numbers
    Vec3 point;       ///< on the ground
    Vec3 seen;        ///< the share of the backdrop if it is transparent
    SeenAs as;
    float mirrored = 0;  ///< > 0: seen directly by the camera, through layers that transmit this
};

/// The shadows on the ground: takes from samples the light that does not reach what they see there.
class GroundShadows {
  public:
    explicit GroundShadows(const RenderContext& context) : context_(context), shadows_(context) {}

    void clear() { views_.clear(); }
    void add(const GroundView& view) { views_.push_back(view); }

    /// Traces the shadow rays of all views.
    void trace(SampleBuffer& buffer);

    /// Takes what the ground mirrors, of which a surface covers `throughput`, from what the sample
    /// sees on the ground.
    void cover(uint32_t slot, const Vec3& throughput, SampleBuffer& buffer) const;

  private:
    void sample_sky(const SampleBuffer& buffer);
    void add_lights(uint32_t view);
    void add_ray(uint32_t view, const LightSample& light, const Vec3& share);
    void lose(const GroundView& view, const Vec3& loss, SampleBuffer& buffer) const;
    void take(uint32_t slot, SeenAs as, const Vec3& loss, SampleBuffer& buffer) const;

    const RenderContext& context_;
    ShadowRays shadows_;
    std::vector<GroundView> views_;
    std::vector<EnvironmentSample> sky_;  // by view
    std::vector<uint32_t> indices_, seeds_;
    std::vector<float> x_, y_;
    std::vector<uint32_t> view_of_ray_;
    std::vector<Vec3> given_;  // by ray
};

/// How a sample keeps the background that it sees.
SeenAs seen_as(Background background);

}  // namespace sightline
