#pragma once
#include "render/ground_shadows.h"
#include "render/path.h"

namespace sightline {

/// What rays see that hit nothing: the background, the environment, the ground.
class Backdrop {
  public:
    explicit Backdrop(const RenderContext& context) : context_(context) {}

    /// Makes misses of the rays that pass the ground before they hit anything.
    void pass_ground(Wave& wave) const;

    /// Adds to the samples what the misses of a wave see, and keeps what they see on the ground.
    void add(const Wave& wave, GroundShadows& ground, SampleBuffer& buffer);

  private:
    bool sees_background(const Path& path) const;
    void add_background(const Wave& wave, uint32_t i, GroundShadows& ground, SampleBuffer& buffer);
    void add_environment(const Wave& wave, GroundShadows& ground, SampleBuffer& buffer);
    void add_ground_view(const Wave& wave, uint32_t i, const Vec3& unshadowed, float weight,
                         SeenAs as, GroundShadows& ground, SampleBuffer& buffer) const;
    /// The distance at which the ray passes the ground, or infinity.
    static float ground_distance(const Wave& wave, uint32_t i) {
        return wave.ground.empty() ? std::numeric_limits<float>::infinity() : wave.ground[i];
    }

    const RenderContext& context_;
    std::vector<uint32_t> rays_;  // that see the environment, or a ground that is a surface
    std::vector<Vec3> directions_, radiances_;
    std::vector<float> pdfs_;
};

}  // namespace sightline
