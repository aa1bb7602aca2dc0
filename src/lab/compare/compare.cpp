#include "lab/compare/compare.h"

#include "core/parallel.h"
#include "core/progress.h"
#include "intersect/ray_rules.h"
#include "lab/compare/judging.h"
#include "lab/compare/timing.h"

#include <algorithm>
#include <mutex>

namespace sightline {
namespace {

constexpr size_t chunk_rays = 1024;

/// A run of rays of one kind, as the engines get them.
struct Chunk {
    RayKind kind;
    std::span<const uint32_t> rays;
};

/// What the engines said of a chunk, engine by engine.
struct Answers {
    std::vector<Ray> rays;
    std::vector<std::vector<Hit>> hits;
    std::vector<std::vector<uint8_t>> blocked;

    bool agree_on(size_t i) const {
        for (size_t e = 1; e < std::max(hits.size(), blocked.size()); ++e) {
            if (!blocked.empty() && blocked[e][i] != blocked[0][i]) return false;
            if (!hits.empty() && surface_of(hits[e][i]) != surface_of(hits[0][i])) return false;
        }
        return true;
    }
};

/// An even hash of a number: SplitMix64's last step.
uint64_t scramble(uint64_t x) {
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

class Court {
  public:
    Court(const Scene& scene, const Referee& referee, std::span<const RecordedRay> rays,
          std::span<const Engine> engines, const CompareOptions& options)
        : scene_(scene), referee_(referee), rays_(rays), engines_(engines) {
        const double part =
            static_cast<double>(options.max_judged) / static_cast<double>(rays.size());
        sampled_below_ = part >= 1 ? UINT64_MAX : static_cast<uint64_t>(part * 0x1p64);
    }

    /// Traces and judges a chunk. Thread-safe: adds its scores up in whole numbers and maxima.
    void hear(const Chunk& chunk, Comparison& result) {
        const Answers answers = ask(chunk);
        std::vector<KindScore> scores(engines_.size());
        std::vector<RayFinding> findings;
        for (size_t i = 0; i < chunk.rays.size(); ++i) judge(chunk, answers, i, scores, findings);
        const std::lock_guard lock(merging_);
        for (size_t e = 0; e < engines_.size(); ++e)
            result.engines[e].kinds[static_cast<size_t>(chunk.kind)].add(scores[e]);
        result.findings.insert(result.findings.end(), findings.begin(), findings.end());
    }

  private:
    Answers ask(const Chunk& chunk) const {
        Answers answers;
        for (const uint32_t i : chunk.rays) answers.rays.push_back(rays_[i].ray);
        const Coherence usual =
            chunk.kind == RayKind::camera ? Coherence::coherent : Coherence::incoherent;
        for (const Engine& engine : engines_)
            if (chunk.kind == RayKind::shadow)
                engine.occluded(answers.rays, answers.blocked.emplace_back(answers.rays.size()),
                                usual);
            else
                engine.closest(answers.rays, answers.hits.emplace_back(answers.rays.size()), usual);
        return answers;
    }

    void judge(const Chunk& chunk, const Answers& answers, size_t i, std::vector<KindScore>& scores,
               std::vector<RayFinding>& findings) const {
        const uint32_t index = chunk.rays[i];
        if (scramble(index) > sampled_below_ && answers.agree_on(i)) {
            for (KindScore& score : scores) ++score.tally.unchecked;
            return;
        }
        const Ray& ray = answers.rays[i];
        const Truth truth = truth_of(referee_, ray);
        for (uint32_t e = 0; e < engines_.size(); ++e) {
            Verdict verdict;
            if (chunk.kind == RayKind::shadow) {
                verdict = occlusion_verdict_of(referee_, ray, truth, answers.blocked[e][i]);
            } else {
                const Hit& hit = answers.hits[e][i];
                verdict = verdict_of(referee_, ray, truth, hit);
                scores[e].tally.self_hits += chunk.kind != RayKind::camera && is_self_hit(ray, hit);
                if (verdict == Verdict::same || verdict == Verdict::tie)
                    measure(index, ray, truth, hit, scores[e]);
            }
            scores[e].tally.count(verdict);
            if (verdict != Verdict::same && verdict != Verdict::tie)
                findings.push_back({index, e, verdict});
        }
    }

    /// How far off a right answer lies.
    void measure(uint32_t index, const Ray& ray, const Truth& truth, const Hit& hit,
                 KindScore& score) const {
        if (!hit) return;
        const double ulps = ulps_between(hit.t, truth.t);
        score.tally.t_ulps.add(ulps);
        if (score.worst_t_ray == none || ulps > score.worst_t_ulps) {
            score.worst_t_ulps = ulps;
            score.worst_t_ray = index;
        }
        const Hit exact = exact_hit_of(scene_, ray, truth, surface_of(hit));
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

/// The rays' indices by kind, in their order.
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

Tally EngineScore::total() const {
    Tally sum;
    for (const KindScore& kind : kinds) sum.add(kind.tally);
    return sum;
}

Comparison compare(const Scene& scene, const Referee& referee, std::span<const RecordedRay> rays,
                   std::span<const Engine> engines, const CompareOptions& options) {
    Comparison result;
    for (const Engine& engine : engines)
        result.engines.push_back(
            {engine.name, engine.intersector->description(), engine.intersector->memory(), {}});
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
    Court court(scene, referee, rays, engines, options);
    Progress progress("compare", chunks.size(), options.show_progress);
    run_with_threads(options.threads, [&] {
        parallel_for(chunks.size(), [&](size_t i) {
            court.hear(chunks[i], result);
            progress.advance();
        });
    });
    std::ranges::sort(result.findings, {},
                      [](const RayFinding& f) { return std::pair(f.ray, f.engine); });
    return result;
}

RayReport inspect(const Scene& scene, const Referee& referee, std::span<const Engine> engines,
                  const Ray& ray) {
    RayReport report;
    report.truth = truth_of(referee, ray);
    const Truth& truth = report.truth;
    for (const Engine& engine : engines) {
        EngineAnswer& answer = report.answers.emplace_back();
        uint8_t blocked = 0;
        engine.closest({&ray, 1}, {&answer.hit, 1}, Coherence::incoherent);
        engine.occluded({&ray, 1}, {&blocked, 1}, Coherence::incoherent);
        answer.blocked = blocked != 0;
        answer.verdict = verdict_of(referee, ray, truth, answer.hit);
        answer.occlusion_verdict = occlusion_verdict_of(referee, ray, truth, answer.blocked);
        if (!answer.hit || truth.nearest.empty()) continue;
        const bool right = std::ranges::count(truth.nearest, surface_of(answer.hit)) > 0;
        const SurfaceId surface = right ? surface_of(answer.hit) : truth.nearest[0];
        answer.t_ulps = ulps_between(answer.hit.t, truth.t);
        answer.normal_angle =
            normal_angle(scene, ray, answer.hit, exact_hit_of(scene, ray, truth, surface));
    }
    return report;
}

}  // namespace sightline
