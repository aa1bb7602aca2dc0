#include "lab/compare/timing.h"

#include "lab/instructions.h"

#include <algorithm>
#include <ctime>

namespace sightline {
namespace {

// A wave as the renderer's.
constexpr size_t wave_rays = 1024;

/// Whole waves, evenly spread over what there is.
std::vector<std::vector<Ray>> pick_waves(std::span<const RecordedRay> rays,
                                         std::span<const uint32_t> which, size_t wanted) {
    const size_t there = (which.size() + wave_rays - 1) / wave_rays;
    const size_t taken = std::min(there, std::max<size_t>(1, wanted / wave_rays));
    std::vector<std::vector<Ray>> waves(taken);
    for (size_t k = 0; k < taken; ++k) {
        const size_t begin = k * there / taken * wave_rays;
        for (size_t i = begin; i < std::min(begin + wave_rays, which.size()); ++i)
            waves[k].push_back(rays[which[i]].ray);
    }
    return waves;
}

/// Nanoseconds that this thread has computed: other programs' share of the processor is left out.
double thread_time() {
    std::timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return 1e9 * static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec);
}

/// Of a ray.
struct RayCost {
    double ns;
    std::optional<double> instructions;
};

RayCost trace_all(const Engine& engine, const std::vector<std::vector<Ray>>& waves, RayKind kind) {
    std::vector<Hit> hits(wave_rays);
    std::vector<uint8_t> blocked(wave_rays);
    const Coherence usual = kind == RayKind::camera ? Coherence::coherent : Coherence::incoherent;
    size_t count = 0;
    const auto counted = thread_instructions();
    const double begin = thread_time();
    for (const std::vector<Ray>& wave : waves) {
        if (kind == RayKind::shadow)
            engine.occluded(wave, std::span(blocked).first(wave.size()), usual);
        else
            engine.closest(wave, std::span(hits).first(wave.size()), usual);
        count += wave.size();
    }
    const auto rays = static_cast<double>(count);
    RayCost cost{(thread_time() - begin) / rays, std::nullopt};
    if (counted) cost.instructions = static_cast<double>(*thread_instructions() - *counted) / rays;
    return cost;
}

}  // namespace

void time_engines(std::span<const Engine> engines, std::span<const RecordedRay> rays,
                  std::span<const uint32_t> which, const CompareOptions& options,
                  std::vector<EngineScore>& scores) {
    if (which.empty()) return;
    const RayKind kind = rays[which[0]].kind;
    const auto waves = pick_waves(rays, which, options.timed_rays);
    const auto score = [&](size_t e) -> KindScore& {
        return scores[e].kinds[static_cast<size_t>(kind)];
    };
    for (int round = 0; round < options.rounds; ++round)
        for (size_t turn = 0; turn < engines.size(); ++turn) {
            const size_t e = (turn + static_cast<size_t>(round)) % engines.size();
            const RayCost cost = trace_all(engines[e], waves, kind);
            score(e).ns_per_ray.push_back(cost.ns);
            score(e).instructions_per_ray = cost.instructions;  // those of the last round
        }
    for (size_t e = 0; e < engines.size(); ++e) std::ranges::sort(score(e).ns_per_ray);
}

}  // namespace sightline
