#pragma once
// The same rays through several engines, each answer judged by the referee.
#include "intersect/engines.h"
#include "lab/tally.h"
#include "render/wave_tracer.h"

namespace sightline {

struct CompareOptions {
    uint64_t max_judged = 1 << 23;  ///< beyond it: a sample, and all rays on which engines differ
    int rounds = 5;                 ///< of timing
    size_t timed_rays = 1 << 14;    ///< of each kind
    unsigned threads = 0;           ///< for all but the timing; 0: all
    bool show_progress = false;
};

/// What an engine made of the rays of one kind.
struct KindScore {
    Tally tally;
    Quantiles barycentrics;  ///< the larger error of u and v, where the triangle is the right one
    Quantiles normal_angle;  ///< degrees between the interpolated normal and that at the exact hit
    std::vector<double> ns_per_ray;              ///< one a round, ascending
    std::optional<double> instructions_per_ray;  ///< where they can be counted
    double worst_t_ulps = 0;
    uint32_t worst_t_ray = none;

    void add(const KindScore& other);
};

struct EngineScore {
    std::string name, description;
    size_t memory = 0;
    std::array<KindScore, ray_kinds> kinds;

    Tally total() const;
};

/// A ray of which an engine did not say what the truth is.
struct RayFinding {
    uint32_t ray;     ///< into the rays compared
    uint32_t engine;  ///< into the engines
    Verdict verdict;  ///< neither same nor tie
};

struct Comparison {
    std::array<uint64_t, ray_kinds> rays{};
    uint64_t invalid_rays = 0;  ///< they hit nothing by definition, and are judged so
    std::vector<EngineScore> engines;
    std::vector<RayFinding> findings;  ///< by ray, then engine
};

/// Fires the rays through the engines: the nearest hit of each, but of a shadow ray what the
/// renderer asks, whether anything blocks it. Camera rays go as coherent calls. The result is the
/// same for any number of threads, but for the times.
Comparison compare(const Scene& scene, const Referee& referee, std::span<const RecordedRay> rays,
                   std::span<const Engine> engines, const CompareOptions& options = {});

/// What one engine says of one ray.
struct EngineAnswer {
    Hit hit;
    bool blocked = false;
    Verdict verdict = Verdict::same, occlusion_verdict = Verdict::same;
    double t_ulps = 0;  ///< where both hit
    double normal_angle = 0;
};

/// All that can be said of one ray; each engine gets it alone.
struct RayReport {
    Truth truth;
    std::vector<EngineAnswer> answers;  ///< by engine
};
RayReport inspect(const Scene& scene, const Referee& referee, std::span<const Engine> engines,
                  const Ray& ray);

}  // namespace sightline
