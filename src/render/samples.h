#pragma once
// Camera samples on their way through a wave tracer: the request, the result, the counts.
#include "intersect/ray_file.h"

#include <array>
#include <span>
#include <vector>

namespace sightline {

/// What a render did, in whole numbers, so that the sums do not depend on their order.
struct Counters {
    std::array<uint64_t, ray_kinds> rays{};
    uint64_t coloured_shadow_rays = 0;  ///< shadow rays that hit a translucent surface
    uint64_t uncovered_hits = 0;        ///< hits whose coverage is below 1
    uint64_t seen_surfaces = 0;  ///< hits of camera rays on surfaces that are not fully transparent
    uint64_t absorbed_rays = 0;  ///< rays that crossed an absorbing volume
    uint64_t area_light_samples = 0, environment_samples = 0;
    uint64_t cut_rays = 0;       ///< secondary rays of small weight that were not traced
    uint64_t samples = 0;        ///< camera samples
    uint64_t depth_reached = 0;  ///< the deepest wave that held a ray (merged by max)

    void add(const Counters& other);
};

struct SampleRequest {
    int x, y;        ///< pixel
    uint32_t index;  ///< of the sample within the pixel
};

/// The first surface of a camera sample that is not fully transparent. In world units, relative to
/// the origin of the scene's frame.
struct FirstHit {
    bool valid = false;
    float depth = 0;  ///< along the view axis
    Vec3 position{0, 0, 0}, normal{0, 0, 0}, albedo{0, 0, 0};
    Vec2 uv{0, 0};  ///< TEXCOORD_0, for the first sample of a pixel only
    uint32_t object = none, material = none;
};

/// The result of one camera sample.
struct Sample {
    Vec3 radiance{0, 0, 0};
    float alpha = 1;          ///< 1 − the share of the transparent background
    Vec3 shown{0, 0, 0};      ///< the part of radiance that the tone map leaves alone
    float shown_share = 0;    ///< and its share of the sample
    Vec3 through{0, 0, 0};    ///< the part of a transparent background that is seen, with shadows
    float through_share = 0;  ///< and its share of the sample
    Vec3 ground{0, 0, 0};     ///< what the camera sees on the ground that mirrors, uncovered
    uint32_t rays = 0;
    FirstHit first;
};

/// A surface that a camera sample sees directly, and the share of the sample that it covers.
struct CoverageSample {
    uint32_t slot;  ///< index of the request
    uint32_t object, material;
    float coverage;
};

/// The samples of one call of WaveTracer::trace. A sample's index is called its slot.
struct SampleBuffer {
    std::span<const SampleRequest> requests;
    std::vector<Sample> samples;  ///< by slot
    size_t light_groups = 0;
    std::vector<Vec3> light_by_group;      ///< radiance, by slot · light_groups + group
    std::vector<CoverageSample> coverage;  ///< if the settings request Cryptomatte
    Counters* counters = nullptr;
    std::vector<RecordedRay>* recorded = nullptr;  ///< or nullptr

    void start(std::span<const SampleRequest> new_requests);
    void add_radiance(uint32_t slot, uint16_t group, const Vec3& radiance) {
        samples[slot].radiance += radiance;
        if (light_groups) light_by_group[slot * light_groups + group] += radiance;
    }
    /// Of radiance that has been added: `color` as the camera sees it through what transmits
    /// `throughput` and covers the rest.
    void add_shown(uint32_t slot, const Vec3& throughput, const Vec3& color) {
        samples[slot].shown += throughput * color;
        samples[slot].shown_share += luminance(throughput);
    }
    /// The same of a transparent background, which adds no radiance.
    void add_through(uint32_t slot, const Vec3& throughput) {
        samples[slot].alpha -= luminance(throughput);
        samples[slot].through += throughput;
        samples[slot].through_share += luminance(throughput);
    }
    /// `source`: the surface that the ray leaves; `none` for camera rays.
    void count_ray(const Ray& ray, RayKind kind, uint32_t slot, const SurfaceId& source) {
        ++counters->rays[static_cast<size_t>(kind)];
        ++samples[slot].rays;
        if (recorded) recorded->push_back({ray, kind, requests[slot].x, requests[slot].y, source});
    }
};

}  // namespace sightline
