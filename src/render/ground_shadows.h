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
    float mirrored = 0;    ///< > 0: seen directly by the camera, through layers that transmit this
    Vec3 albedo{0, 0, 0};  ///< of a surface, as the sample sees it
};

/// The shadows on the ground: takes from samples the light that does not reach what they see there.
/// Adds to them the light of emissive surfaces that does.
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
    /// What a view has been given of a light before it is known what arrives.
    struct Given {
        uint32_t view;
        Vec3 light;
        uint16_t light_group;
    };

    void generate_samples(uint32_t dimension, const SampleBuffer& buffer);
    void sample_sky(const SampleBuffer& buffer);
    void sample_emitters(SampleBuffer& buffer);
    void add_lights(uint32_t view);
    void add_ray(uint32_t view, const LightSample& light, const Vec3& share);
    void lose(const Given& given, const Vec3& loss, SampleBuffer& buffer) const;
    void take(uint32_t slot, SeenAs as, uint16_t light_group, const Vec3& loss,
              SampleBuffer& buffer) const;

    const RenderContext& context_;
    ShadowRays shadows_;
    std::vector<GroundView> views_;
    std::vector<EnvironmentSample> sky_;  // by view
    std::vector<uint32_t> indices_, seeds_;
    std::vector<float> x_, y_;  // of generate_samples, by view
    std::vector<float> emitter_x_, emitter_y_;
    std::vector<Given> given_;  // by ray
};

/// How a sample keeps the background that it sees.
SeenAs seen_as(Background background);

}  // namespace sightline
