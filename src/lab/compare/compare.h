#pragma once
// Traces the same rays with several engines and has the referee judge each answer.
#include "intersect/engines.h"
#include "intersect/ray_file.h"
#include "lab/tally.h"

#include <stop_token>

namespace sightline {

struct CompareOptions {
    /// With more rays than this, about as many are judged: a random sample, plus all rays on which
    /// the engines differ.
    uint64_t max_judged = 1 << 23;
    int rounds = 5;               ///< rounds of timing
    size_t timed_rays = 1 << 14;  ///< rays timed of each kind
    unsigned threads = 0;         ///< for everything but timing, which uses one; 0: all cores
    bool show_progress = false;
    bool keep_verdicts = false;  ///< fills Comparison::verdicts
    std::stop_token stop = {};   ///< ends timing and judging early
};

/// What an engine adds to the library behind it, on the same rays in turns.
struct WrapperCost {
    std::string library_call;  ///< the library's function that was called alone
    double bare_ns = 0;        ///< a ray of the library alone, the median of the rounds
    double factor = 1;         ///< the engine's time over that, the median of the rounds
};

/// An engine's answers for the rays of one kind.
struct KindScore {
    Tally tally;
    Quantiles barycentrics;  ///< max(|Δu|, |Δv|) on correct triangles
    Quantiles normal_angle;  ///< degrees between the interpolated normals at hit and exact hit
    std::vector<double> ns_per_ray;              ///< one per round, ascending
    std::optional<double> instructions_per_ray;  ///< if the machine can count them
    std::optional<WrapperCost> wrapper;          ///< if a library is behind the engine
    double worst_t_ulps = 0;
    uint32_t worst_t_ray = none;  ///< index of the ray with worst_t_ulps

    void add(const KindScore& other);
    std::optional<double> median_ns() const;  ///< per ray; none if not timed
};

struct EngineScore {
    std::string name, description;
    size_t memory = 0;
    std::vector<std::string> warnings;  ///< Intersector::warnings
    std::array<KindScore, ray_kinds> kinds;

    Tally total() const;
    std::optional<double> mean_ns() const;  ///< mean over all rays of the kinds' medians
};

/// A ray for which an engine's answer is not the truth.
struct RayFinding {
    uint32_t ray;     ///< index into the rays compared
    uint32_t engine;  ///< index into the engines
    Verdict verdict;  ///< neither same nor tie
};

/// Stands in Comparison::verdicts for a ray that was not judged.
inline constexpr uint8_t not_judged = 255;

struct Comparison {
    std::array<uint64_t, ray_kinds> rays{};
    uint64_t invalid_rays = 0;  ///< see is_valid; by definition they hit nothing
    uint64_t rays_left = 0;     ///< not reached before a stop: no score counts them
    std::vector<EngineScore> engines;
    std::vector<std::string> notes;    ///< what a reader of the scores has to know, one line each
    std::vector<RayFinding> findings;  ///< sorted by ray, then engine
    /// By engine and ray: the Verdict, or not_judged. Empty unless CompareOptions::keep_verdicts.
    std::vector<std::vector<uint8_t>> verdicts;
};

/// Traces the rays with every engine: any-hit queries for shadow rays, closest-hit queries for the
/// others; camera rays in coherent calls. Apart from the times, the result does not depend on the
/// number of threads.
Comparison compare(const Scene& scene, const Referee& referee, std::span<const RecordedRay> rays,
                   std::span<const Engine> engines, const CompareOptions& options = {});

/// An engine's answer for one ray.
struct EngineAnswer {
    Hit hit;
    bool occluded = false;
    Verdict verdict = Verdict::same, occlusion_verdict = Verdict::same;
    double t_ulps = 0;        ///< error of t, if engine and referee report a hit
    double normal_angle = 0;  ///< degrees, likewise
};

/// The truth and all answers for one ray.
struct RayReport {
    Truth truth;
    std::vector<EngineAnswer> answers;  ///< by engine
};

/// Traces one ray alone with every engine, by closest-hit and any-hit queries.
RayReport inspect(const Scene& scene, const Referee& referee, std::span<const Engine> engines,
                  const RecordedRay& recorded);

}  // namespace sightline
