#pragma once
// Whitted's recursion unrolled into waves of rays, one tile at a time.
#include "intersect/intersector.h"
#include "render/render_context.h"
#include "shade/bsdf.h"
#include "shade/media.h"

#include <array>
#include <optional>

namespace sightline {

enum class RayKind : uint32_t { camera, shadow, reflection, refraction };
inline constexpr size_t ray_kinds = 4;
inline constexpr const char* ray_kind_names[] = {"camera", "shadow", "reflection", "refraction"};

/// What was done, in whole numbers, so that sums do not depend on their order.
struct Counters {
    std::array<uint64_t, ray_kinds> rays{};
    uint64_t coloured_shadow_rays = 0;  ///< shadow rays that met a translucent surface
    uint64_t uncovered_hits = 0;        ///< hits whose coverage is below 1
    uint64_t absorbed_rays = 0;         ///< rays that crossed an absorbing volume
    uint64_t area_light_samples = 0, environment_samples = 0;
    uint64_t cut_rays = 0;       ///< secondary rays whose weight was below the cutoff
    uint64_t samples = 0;        ///< camera samples
    uint64_t depth_reached = 0;  ///< the deepest wave that held a ray (merged by max)

    void add(const Counters& other);
};

/// A ray as it was traced, for replay.
struct RecordedRay {
    Ray ray;
    RayKind kind;
    int x = -1, y = -1;  ///< the pixel that it was traced for; negative: not known
};

/// What the eye sees first in one sample.
struct FirstHit {
    bool valid = false;
    float depth = 0;  ///< along the view axis
    Vec3 position{0, 0, 0}, normal{0, 0, 0}, albedo{0, 0, 0};
    Vec2 uv{0, 0};
    uint32_t object = none, material = none;
};

/// A surface that the eye saw in a sample, and how much of the sample it covers.
struct Seen {
    uint32_t slot, object, material;
    float coverage;
};

/// The result of one camera sample.
struct Sample {
    Vec3 radiance{0, 0, 0};
    float alpha = 1;  ///< 1 − what of the transparent background shows through
    uint32_t rays = 0;
    FirstHit first;
};

/// Traces camera samples to their radiance. Holds the waves' arrays, reused from call to call;
/// one per thread.
class WaveTracer {
  public:
    explicit WaveTracer(const RenderContext& context)
        : t_(context), light_groups_(context.names.light_groups.size()) {}

    struct Request {
        int x, y;         ///< pixel
        uint32_t sample;  ///< its running number within the pixel
    };
    /// Fills `samples[i]` for `requests[i]`. `recorded` may be null.
    void trace(std::span<const Request> requests, std::span<Sample> samples, Counters& counters,
               std::vector<RecordedRay>* recorded);

    /// Of the last `trace`, where the settings asks for light groups: the groups' shares of each
    /// sample's radiance, sample by sample.
    std::span<const Vec3> light_by_group() const { return group_light_; }
    /// Of the last `trace`, where the settings asks for Cryptomatte; slots are indices of requests.
    std::span<const Seen> seen() const { return seen_; }

  private:
    // A ray may cross so many covered layers before it counts as blocked: more would be a fault
    // of the file, and the loop must end.
    static constexpr int max_layers = 256;

    /// What random numbers are for; each use has a sequence of its own.
    enum class Dimension : uint32_t {
        pixel,
        lens,
        reflection,
        refraction,
        coat,
        environment,
        emitter,
        which_emitter
    };
    struct Points {
        std::vector<float> x, y;
        Vec2 operator[](size_t i) const { return {x[i], y[i]}; }
    };

    struct Path {
        uint32_t slot;    // into requests and samples
        uint32_t stream;  // seed of this branch's random numbers
        Vec3 weight;
        float pdf;            // of the direction, per solid angle; 0 where it was not sampled
        float width, spread;  // of the ray cone
        uint16_t depth, layers;
        bool from_eye;  // came straight from the eye, through coverage only
        RayKind kind;
        MediumStack media;
    };
    struct Shadow {
        Vec3 light;  // what arrives if nothing blocks
        uint32_t slot;
        uint16_t group;
        MediumStack media;
    };
    struct ShadowWave {
        std::vector<Ray> rays;
        std::vector<Shadow> shadows;
        void clear() { rays.clear(), shadows.clear(); }
    };

    void start(std::span<const Request> requests);
    void aim(std::span<const Request> requests);
    template <class PathOf>
    void draw(size_t count, Dimension number, const PathOf& path_of, Points& points);
    void shade_wave();
    void shade_misses();
    void draw_for_hits();
    void shade_hit(size_t k);  // rays_[met_[k]]
    void record_first(const Path& path, const Ray& ray, const Hit& hit, const Surface& surface);
    void continue_behind(const Path& path, const Ray& ray, const Surface& surface, float distance);
    void add_emission(const Path& path, const Ray& ray, const Hit& hit, const Surface& surface);
    float eta_at(const MediumStack& media, const Surface& surface) const;
    bool send_on(const Path& path, const Surface& surface, size_t k, float width);
    void light_directly(const Path& path, const Surface& surface, size_t k, bool lobes_are_traced);
    void add_shadow(ShadowWave& wave, const Path& path, const Surface& surface, const LightSample&,
                    const Vec3& light, uint16_t group);
    void add_light(uint32_t slot, uint16_t group, const Vec3& light) {
        samples_[slot].radiance += light;
        if (light_groups_) group_light_[slot * light_groups_ + group] += light;
    }
    void resolve(ShadowWave& wave, Coherence coherence);
    void filter_light(ShadowWave& wave);
    void pass_layer(Shadow& shadow, Ray& ray, const Hit& hit) const;
    uint32_t dimension(const Path& path, Dimension number) const;
    uint32_t seed(const Path& path) const { return seeds_[path.slot] ^ path.stream; }
    uint32_t index(const Path& path) const { return requests_[path.slot].sample; }
    void record(const Ray& ray, RayKind kind, uint32_t slot) {
        ++counters_->rays[static_cast<size_t>(kind)];
        ++samples_[slot].rays;
        if (recorded_) recorded_->push_back({ray, kind, requests_[slot].x, requests_[slot].y});
    }

    const RenderContext& t_;
    std::span<const Request> requests_;
    std::span<Sample> samples_;
    Counters* counters_ = nullptr;
    std::vector<RecordedRay>* recorded_ = nullptr;

    size_t light_groups_;
    std::vector<Vec3> group_light_;
    std::vector<Seen> seen_;
    std::vector<uint32_t> seeds_;  // by slot
    std::vector<uint32_t> draw_indices_, draw_seeds_;
    Points on_pixel_, on_lens_;                                     // by slot
    Points on_lobe_, on_environment_, on_emitter_, which_emitter_;  // by met_
    std::vector<float> raster_x_, raster_y_;                        // of camera rays
    std::vector<Ray> rays_, next_rays_;
    std::vector<Path> paths_, next_paths_;
    std::vector<Hit> hits_;
    std::vector<uint32_t> met_, missed_;        // rays of the wave that hit something, or nothing
    std::vector<Vec3> directions_, radiances_;  // of those that see the environment
    std::vector<float> pdfs_;
    std::vector<EnvironmentSample> environment_samples_;  // by met_
    ShadowWave punctual_, sampled_;
    std::vector<uint8_t> blocked_;
    std::vector<uint32_t> open_shadows_;  // still to be walked through translucent layers
    std::vector<Ray> layer_rays_;
    std::vector<Hit> layer_hits_;
};

}  // namespace sightline
