#pragma once
// Whitted's recursion unrolled into waves of rays, one tile at a time. The stages of a wave are
// those of pbrt's wavefront integrator (Pharr, Jakob & Humphreys, 4th ed. 2023, section 15.3).
#include "render/backdrop.h"
#include "render/direct_light.h"
#include "render/path.h"

#include <optional>

namespace sightline {

// The estimator of the radiance L from a surface towards wo. X is a set of sampled lights, either
// the environment or the emissive triangles; wi is a direction sampled from it.
//
//   L  = alpha · (Le + Lp + Ld + Lg + Ls) + (1 − alpha) · L(behind)
//
//   Lp = Σ f(wi) E V                      over punctual lights with irradiance E
//   Ld = Σ fd(wi) LX(wi) V / pX(wi)       over X
//   Lg = Σ wX fg(wi) LX(wi) U / pX(wi)    over X
//        + fg(wb) L(wb) / pb(wb)          one secondary ray; LX within L(wb) has the weight wB
//   Ls = Σ F L(w)                         over smooth lobes: Fresnel weight, only direction
//
//   wX = pX² / (pX² + pb²),  wB = pb² / (pX² + pb²)
//
// f = fd + fg, the diffuse and the rough glossy lobes, includes |cos|. U is 0, or the transmittance
// of the layers that leave the direction unbent; V includes those that bend or blur. Path::pdf
// carries pb to the light through the layers of U, where wB is applied; pX there is that of the
// vertex where the ray began, Path::straight_length before the last layer. Any other scattering
// between makes a path that no light sample makes, so that wB is 1. It is also 1 if X is not
// sampled; wX is 1, and U is V, if no ray samples the lobe. At the last bounce the secondary ray
// sees X alone and crosses what transmits like a shadow ray, so that U is V there. A path's
// throughput is the product of its factors; rays of small weight are subject to Russian roulette,
// and none is spawned that could not bring as much as the cutoff. A sample's radiance is the sum of
// all terms, added as each stage computes them.

/// Traces camera samples to their radiance. Owns the arrays of the waves and reuses them from call
/// to call; one per thread.
class WaveTracer {
  public:
    explicit WaveTracer(const RenderContext& context);

    /// The samples of the requests, valid until the next call. `recorded` may be null.
    const SampleBuffer& trace(std::span<const SampleRequest> requests, Counters& counters,
                              std::vector<RecordedRay>* recorded);

  private:
    /// Uses of random numbers; each has a sequence of its own. The values seed the sequences.
    enum class Dimension : uint32_t {
        pixel,
        lens,
        reflection,
        refraction,
        coat,
        environment,
        emitter,
        which_emitter,
        roulette
    };
    struct Samples2D {
        std::vector<float> x, y;
        Vec2 operator[](size_t i) const { return {x[i], y[i]}; }
    };

    // Random numbers of the hits of a wave and the environment's samples; all by k, the index
    // of the hit in Wave::hit_indices.
    struct HitSamples {
        Samples2D lobe, environment, emitter, which_emitter;
        std::vector<EnvironmentSample> environment_lights;
    };

    struct CameraSamples {  // by slot
        Samples2D pixel, lens;
        std::vector<float> raster_x, raster_y;
    };

    struct HitSurface {
        Surface surface;
        std::optional<size_t> coincident;  // index in coincident_hits_, if others may coincide
    };

    void generate_camera_rays();
    void intersect_closest(Coherence coherence);
    void generate_hit_samples();
    void handle_escaped_rays();
    void spawn_ground_mirror(uint32_t i);
    void evaluate_materials();
    void evaluate_material(size_t k, HitSurface& at_hit);
    bool may_coincide(const Surface& surface) const;
    void visit_coincident(const Path& path, const Ray& ray, std::span<const Hit> coincident,
                          const Vec3& point, size_t k);
    void visit_surface(Path path, const Ray& ray, const Hit& hit, Surface& surface, size_t k);
    void scatter(const Path& path, const Surface& surface, size_t k);
    void scatter_by_channel(const Path& path, Surface& surface, const Vec3& etas, size_t k);
    void join_reflections(size_t first, size_t begin);
    void handle_emissive_intersection(const Path& path, const Ray& ray, const Hit& hit,
                                      const Surface& surface);
    GlossyEstimator spawn_secondary_rays(const Path& path, const Bsdf& bsdf, size_t k);
    void add_secondary_ray(Path next, const Surface& surface, const BsdfSample& sample);
    bool survives(Path& path, float survival, uint32_t branch) const;
    void sample_direct_light(const Path& path, const Bsdf& bsdf, size_t k, GlossyEstimator);
    void spawn_alpha_continuation(const Path& path, const Ray& ray, const Surface& surface,
                                  float distance);
    void spawn_last_continuation(const Path& path, const Ray& ray, Surface& surface,
                                 float distance);
    void record_first_hit(const Path& path, const Ray& ray, const Hit& hit, const Surface& surface);

    // True if the environment or emissive triangles are sampled.
    bool samples_lights() const;
    // True for a ray that left its surface at the last bounce: it sees sampled lights alone.
    bool is_last(const Path& path) const { return context_.is_last(path.depth); }

    template <class PathAt>
    void generate_samples(Dimension dimension, size_t count, const PathAt& path_at,
                          Samples2D& samples);
    uint32_t seed(const Path& path) const { return pixel_seeds_[path.slot] ^ path.stream; }
    uint32_t seed(const Path& path, Dimension dimension) const;
    uint32_t sample_index(const Path& path) const { return buffer_.requests[path.slot].index; }

    const RenderContext& context_;
    SampleBuffer buffer_;
    std::vector<uint32_t> pixel_seeds_;                    // by slot
    std::vector<uint32_t> sample_indices_, sample_seeds_;  // of generate_samples
    CameraSamples camera_samples_;
    Wave wave_, next_wave_;
    CoincidentHits coincident_hits_;
    std::vector<HitSurface> hit_surfaces_;  // of a block of hits
    Wave onward_,
        arriving_;  // what goes on behind a surface; what arrives at the next
    HitSamples hit_samples_;
    GroundShadows ground_shadows_;
    Backdrop backdrop_;
    DirectLighting direct_light_;
};

}  // namespace sightline
