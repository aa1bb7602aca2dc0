#include "lab/compare/compare.h"

#include "core/parallel.h"
#include "core/progress.h"
#include "intersect/ray_rules.h"
#include "lab/compare/judging.h"
#include "lab/compare/timing.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <mutex>

namespace sightline {
namespace {

constexpr size_t chunk_rays = 1024;

/// Rays of one kind, traced in one call of each engine.
struct Chunk {
    RayKind kind;
    std::span<const uint32_t> indices;
};

/// Whether two hits are of one surface and differ by no more than a float's rounding explains on
/// well-conditioned rays.
bool are_alike(const Hit& a, const Hit& b) {
    constexpr float tolerance = 0x1p-12f;
    if (surface_of(a) != surface_of(b)) return false;
    if (!a) return true;
    return std::abs(a.t - b.t) <= tolerance * std::abs(b.t) && std::abs(a.u - b.u) <= tolerance &&
           std::abs(a.v - b.v) <= tolerance;
}

/// The engines' answers for a chunk, by engine: hits, or occlusion for shadow rays.
struct ChunkAnswers {
    std::vector<Ray> rays;
    std::vector<std::vector<Hit>> hits;
    std::vector<std::vector<uint8_t>> occluded;

    bool agree_on(size_t i) const {
        for (size_t e = 1; e < std::max(hits.size(), occluded.size()); ++e) {
            if (!occluded.empty() && occluded[e][i] != occluded[0][i]) return false;
            if (!hits.empty() && !are_alike(hits[e][i], hits[0][i])) return false;
        }
        return true;
    }
};

/// The finaliser of SplitMix64 (Steele et al. 2014): a uniform hash.
uint64_t mix_bits(uint64_t x) {
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

/// Traces chunks of rays with all engines and has the referee judge the answers.
class ChunkScorer {
  public:
    ChunkScorer(const Scene& scene, const Referee& referee, std::span<const RecordedRay> rays,
                std::span<const Engine> engines, const CompareOptions& options)
        : scene_(scene), referee_(referee), rays_(rays), engines_(engines) {
        const double fraction =
            static_cast<double>(options.max_judged) / static_cast<double>(rays.size());
        sampled_below_ = fraction >= 1 ? UINT64_MAX : static_cast<uint64_t>(fraction * 0x1p64);
    }

    /// Adds a chunk's scores and findings to `result`. Thread-safe and independent of the order of
    /// chunks, as it adds whole numbers and takes maxima.
    void score(const Chunk& chunk, Comparison& result) {
        const ChunkAnswers answers = trace(chunk);
        std::vector<KindScore> scores(engines_.size());
        std::vector<RayFinding> findings;
        for (size_t i = 0; i < chunk.indices.size(); ++i)
            score_ray(chunk, answers, i, scores, findings, result.verdicts);
        const std::lock_guard lock(merging_);
        for (size_t e = 0; e < engines_.size(); ++e)
            result.engines[e].kinds[static_cast<size_t>(chunk.kind)].add(scores[e]);
        result.findings.insert(result.findings.end(), findings.begin(), findings.end());
    }

  private:
    ChunkAnswers trace(const Chunk& chunk) const {
        ChunkAnswers answers;
        for (const uint32_t i : chunk.indices) answers.rays.push_back(rays_[i].ray);
        const Coherence coherence =
            chunk.kind == RayKind::camera ? Coherence::coherent : Coherence::incoherent;
        for (const Engine& engine : engines_)
            if (chunk.kind == RayKind::shadow)
                engine.intersector->occluded(
                    answers.rays, answers.occluded.emplace_back(answers.rays.size()), coherence);
            else
                engine.intersector->closest(
                    answers.rays, answers.hits.emplace_back(answers.rays.size()), coherence);
        return answers;
    }

    void score_ray(const Chunk& chunk, const ChunkAnswers& answers, size_t i,
                   std::vector<KindScore>& scores, std::vector<RayFinding>& findings,
                   std::vector<std::vector<uint8_t>>& verdicts) const {
        const uint32_t index = chunk.indices[i];
        const bool agreed = answers.agree_on(i);
        if (agreed && mix_bits(index) > sampled_below_) {
            for (KindScore& score : scores) ++score.tally.unchecked;
            return;
        }
        const RecordedRay& ray = rays_[index];
        const Truth truth = find_truth(referee_, ray.ray);
        for (uint32_t e = 0; e < engines_.size(); ++e) {
            Tally& tally = scores[e].tally;
            Verdict verdict;
            if (chunk.kind == RayKind::shadow) {
                verdict = judge_occlusion(referee_, ray, truth, answers.occluded[e][i]);
            } else {
                const Hit& hit = answers.hits[e][i];
                verdict = judge_hit(referee_, ray, truth, hit);
                tally.self_hits += chunk.kind != RayKind::camera && is_self_hit(ray.ray, hit);
                if (verdict == Verdict::same || verdict == Verdict::tie)
                    measure_error(index, ray.ray, truth, hit, scores[e]);
            }
            tally.count(verdict);
            if (!verdicts.empty()) verdicts[e][index] = static_cast<uint8_t>(verdict);
            tally.left_out += is_wrong(verdict) && !truth.nearest.empty() &&
                              engines_[e].intersector->leaves_out(ray.ray, truth.nearest[0]);
            if (agreed && verdict != Verdict::unjudged) {
                ++tally.sampled;
                tally.sampled_wrong += is_wrong(verdict);
            }
            if (verdict != Verdict::same && verdict != Verdict::tie)
                findings.push_back({index, e, verdict});
        }
    }

    /// The errors of a correct answer.
    void measure_error(uint32_t index, const Ray& ray, const Truth& truth, const Hit& hit,
                       KindScore& score) const {
        if (!hit) return;
        const double ulps = ulps_between(hit.t, truth.t);
        score.tally.t_ulps.add(ulps);
        if (score.worst_t_ray == none || ulps > score.worst_t_ulps) {
            score.worst_t_ulps = ulps;
            score.worst_t_ray = index;
        }
        const Hit exact = compute_exact_hit(scene_, ray, truth, surface_of(hit));
        score.normal_angle.add(normal_angle(scene_, ray, hit, exact));
        if (scene_.is_mesh(hit.geometry))
            score.barycentrics.add(static_cast<double>(
                std::max(std::abs(hit.u - exact.u), std::abs(hit.v - exact.v))));
    }

    const Scene& scene_;
    const Referee& referee_;
    std::span<const RecordedRay> rays_;
    std::span<const Engine> engines_;
    uint64_t sampled_below_;
    std::mutex merging_;
};

/// Which engines would all be wrong in the same way about analytic shapes.
std::vector<std::string> notes_on_shapes(const Scene& scene, std::span<const Engine> engines) {
    std::vector<std::string> names;
    for (const Engine& engine : engines)
        if (!engine.measured_ns && !engine.name.starts_with("few-shapes"))
            names.push_back(engine.name);
    if (scene.shapes.empty() || names.size() < 2) return {};
    return {
        fmt::format("{} solve analytic shapes by one function: for shapes, each is compared with "
                    "the referee, but not with one another",
                    fmt::join(names, ", "))};
}

/// Indices of the rays of each kind, in ascending order.
std::array<std::vector<uint32_t>, ray_kinds> sort_by_kind(std::span<const RecordedRay> rays) {
    std::array<std::vector<uint32_t>, ray_kinds> sorted;
    for (uint32_t i = 0; i < rays.size(); ++i)
        sorted[static_cast<size_t>(rays[i].kind)].push_back(i);
    return sorted;
}

}  // namespace

void KindScore::add(const KindScore& other) {
    tally.add(other.tally);
    barycentrics.add(other.barycentrics);
    normal_angle.add(other.normal_angle);
    const bool worse = other.worst_t_ulps > worst_t_ulps ||
                       (other.worst_t_ulps == worst_t_ulps && other.worst_t_ray < worst_t_ray);
    if (other.worst_t_ray == none || !worse) return;
    worst_t_ulps = other.worst_t_ulps;
    worst_t_ray = other.worst_t_ray;
}

std::optional<double> KindScore::median_ns() const {
    if (ns_per_ray.empty()) return std::nullopt;
    return ns_per_ray[ns_per_ray.size() / 2];
}

Tally EngineScore::total() const {
    Tally sum;
    for (const KindScore& kind : kinds) sum.add(kind.tally);
    return sum;
}

std::optional<double> EngineScore::mean_ns() const {
    double sum = 0;
    uint64_t rays = 0;
    for (const KindScore& kind : kinds)
        if (const auto time = kind.median_ns()) {
            sum += *time * static_cast<double>(kind.tally.rays());
            rays += kind.tally.rays();
        }
    if (rays == 0) return std::nullopt;
    return sum / static_cast<double>(rays);
}

Comparison compare(const Scene& scene, const Referee& referee, std::span<const RecordedRay> rays,
                   std::span<const Engine> engines, const CompareOptions& options) {
    Comparison result;
    for (const Engine& engine : engines)
        result.engines.push_back({engine.name,
                                  engine.intersector->description(),
                                  engine.intersector->memory(),
                                  engine.intersector->warnings(),
                                  {}});
    result.notes = notes_on_shapes(scene, engines);
    if (options.keep_verdicts)
        result.verdicts.assign(engines.size(), std::vector<uint8_t>(rays.size(), not_judged));
    const auto by_kind = sort_by_kind(rays);
    std::vector<Chunk> chunks;
    for (size_t kind = 0; kind < ray_kinds; ++kind) {
        const std::span<const uint32_t> all = by_kind[kind];
        result.rays[kind] = all.size();
        for (size_t begin = 0; begin < all.size(); begin += chunk_rays)
            chunks.push_back({static_cast<RayKind>(kind),
                              all.subspan(begin, std::min(chunk_rays, all.size() - begin))});
        time_engines(engines, rays, all, options, result.engines);
    }
    result.invalid_rays = static_cast<uint64_t>(
        std::ranges::count_if(rays, [](const RecordedRay& r) { return !is_valid(r.ray); }));
    // In any order, so that what was judged before a stop is a sample of all.
    std::ranges::sort(chunks, {}, [](const Chunk& c) { return mix_bits(c.indices[0]); });
    ChunkScorer scorer(scene, referee, rays, engines, options);
    Progress progress("compare", {}, chunks.size(), options.show_progress);
    std::atomic<uint64_t> left = 0;
    run_with_threads(options.threads, [&] {
        parallel_for(chunks.size(), [&](size_t i) {
            if (options.stop.stop_requested()) {
                left += chunks[i].indices.size();
                return;
            }
            scorer.score(chunks[i], result);
            progress.advance();
        });
    });
    result.rays_left = left;
    std::ranges::sort(result.findings, {},
                      [](const RayFinding& f) { return std::pair(f.ray, f.engine); });
    return result;
}

RayReport inspect(const Scene& scene, const Referee& referee, std::span<const Engine> engines,
                  const RecordedRay& recorded) {
    const Ray& ray = recorded.ray;
    RayReport report;
    report.truth = find_truth(referee, ray);
    const Truth& truth = report.truth;
    for (const Engine& engine : engines) {
        EngineAnswer& answer = report.answers.emplace_back();
        uint8_t occluded = 0;
        engine.intersector->closest({&ray, 1}, {&answer.hit, 1}, Coherence::incoherent);
        engine.intersector->occluded({&ray, 1}, {&occluded, 1}, Coherence::incoherent);
        answer.occluded = occluded != 0;
        answer.verdict = judge_hit(referee, recorded, truth, answer.hit);
        answer.occlusion_verdict = judge_occlusion(referee, recorded, truth, answer.occluded);
        if (!answer.hit || truth.nearest.empty()) continue;
        const bool correct = std::ranges::count(truth.nearest, surface_of(answer.hit)) > 0;
        const SurfaceId surface = correct ? surface_of(answer.hit) : truth.nearest[0];
        answer.t_ulps = ulps_between(answer.hit.t, truth.t);
        answer.normal_angle =
            normal_angle(scene, ray, answer.hit, compute_exact_hit(scene, ray, truth, surface));
    }
    return report;
}

}  // namespace sightline
