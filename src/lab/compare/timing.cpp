#include "lab/compare/timing.h"

#include "exact/arithmetic.h"
#include "intersect/library_caller.h"
#include "lab/instructions.h"

#include <algorithm>
#include <ctime>

namespace sightline {
namespace {

constexpr size_t wave_rays = 1024;  // similar to the renderer's waves

/// Whole waves, spread evenly over the rays.
std::vector<std::vector<Ray>> pick_waves(std::span<const RecordedRay> rays,
                                         std::span<const uint32_t> indices, size_t max_rays) {
    const size_t available = (indices.size() + wave_rays - 1) / wave_rays;
    const size_t taken = std::min(available, std::max<size_t>(1, max_rays / wave_rays));
    std::vector<std::vector<Ray>> waves(taken);
    for (size_t k = 0; k < taken; ++k) {
        const size_t begin = k * available / taken * wave_rays;
        for (size_t i = begin; i < std::min(begin + wave_rays, indices.size()); ++i)
            waves[k].push_back(rays[indices[i]].ray);
    }
    return waves;
}

/// Processor time of this thread in ns, which excludes that of other programs.
double thread_time() {
    std::timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return 1e9 * static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec);
}

struct RayCost {
    double ns;
    std::optional<double> instructions;
};

Coherence coherence_of(RayKind kind) {
    return kind == RayKind::camera ? Coherence::coherent : Coherence::incoherent;
}

RayCost trace_all(const Engine& engine, const std::vector<std::vector<Ray>>& waves, RayKind kind) {
    std::vector<Hit> hits(wave_rays);
    std::vector<uint8_t> occluded(wave_rays);
    const Coherence coherence = coherence_of(kind);
    size_t count = 0;
    const auto instructions = thread_instructions();
    const double begin = thread_time();
    for (const std::vector<Ray>& wave : waves) {
        if (kind == RayKind::shadow)
            engine.intersector->occluded(wave, std::span(occluded).first(wave.size()), coherence);
        else
            engine.intersector->closest(wave, std::span(hits).first(wave.size()), coherence);
        count += wave.size();
    }
    const auto rays = static_cast<double>(count);
    RayCost cost{(thread_time() - begin) / rays, std::nullopt};
    if (instructions)
        cost.instructions = static_cast<double>(*thread_instructions() - *instructions) / rays;
    return cost;
}

/// The same by the library alone, in ns.
double trace_bare(const LibraryCaller& caller, const std::vector<std::vector<Ray>>& waves,
                  RayKind kind) {
    size_t count = 0;
    const double begin = thread_time();
    for (const std::vector<Ray>& wave : waves) {
        caller.trace_bare(wave, kind == RayKind::shadow, coherence_of(kind));
        count += wave.size();
    }
    return (thread_time() - begin) / static_cast<double>(count);
}

double median_of(std::vector<double> numbers) {
    std::ranges::sort(numbers);
    return numbers[numbers.size() / 2];
}

/// Times an engine and the library behind it in turns; none if there is no library, or no ray that
/// it takes as it is.
std::optional<WrapperCost> time_wrapper(const Engine& engine, std::vector<std::vector<Ray>> waves,
                                        RayKind kind, const CompareOptions& options) {
    const auto* caller = dynamic_cast<const LibraryCaller*>(engine.intersector.get());
    for (std::vector<Ray>& wave : waves)
        std::erase_if(wave, [](const Ray& ray) { return !library_takes(ray); });
    std::erase_if(waves, [](const std::vector<Ray>& wave) { return wave.empty(); });
    if (caller == nullptr || waves.empty()) return std::nullopt;
    auto bare_waves = waves;  // as the engine passes them on
    for (std::vector<Ray>& wave : bare_waves)
        for (Ray& ray : wave) ray.tnear = next_after_tnear(ray.tnear);
    WrapperCost cost;
    cost.library_call =
        caller->trace_bare(bare_waves[0], kind == RayKind::shadow, coherence_of(kind));
    std::vector<double> times, factors;
    for (int round = 0; round < options.rounds && !options.stop.stop_requested(); ++round) {
        const bool bare_first = round % 2 == 0;
        double bare = bare_first ? trace_bare(*caller, bare_waves, kind) : 0;
        const double wrapped = trace_all(engine, waves, kind).ns;
        if (!bare_first) bare = trace_bare(*caller, bare_waves, kind);
        times.push_back(bare);
        factors.push_back(wrapped / bare);
    }
    if (times.empty()) return std::nullopt;
    cost.bare_ns = median_of(times);
    cost.factor = median_of(factors);
    return cost;
}

}  // namespace

void time_engines(std::span<const Engine> engines, std::span<const RecordedRay> rays,
                  std::span<const uint32_t> indices, const CompareOptions& options,
                  std::vector<EngineScore>& scores) {
    if (indices.empty()) return;
    check_arithmetic();  // judging takes place in the same
    const RayKind kind = rays[indices[0]].kind;
    const auto waves = pick_waves(rays, indices, options.timed_rays);
    const auto score = [&](size_t e) -> KindScore& {
        return scores[e].kinds[static_cast<size_t>(kind)];
    };
    for (int round = 0; round < options.rounds; ++round)
        for (size_t turn = 0; turn < engines.size(); ++turn) {
            const size_t e = (turn + static_cast<size_t>(round)) % engines.size();
            if (engines[e].measured_ns || options.stop.stop_requested()) continue;
            const RayCost cost = trace_all(engines[e], waves, kind);
            score(e).ns_per_ray.push_back(cost.ns);
            score(e).instructions_per_ray = cost.instructions;  // of the last round
        }
    for (size_t e = 0; e < engines.size(); ++e) {
        std::ranges::sort(score(e).ns_per_ray);
        if (!engines[e].measured_ns) {
            score(e).wrapper = time_wrapper(engines[e], waves, kind, options);
            continue;
        }
        const double measured = (*engines[e].measured_ns)[static_cast<size_t>(kind)];
        if (std::isfinite(measured)) score(e).ns_per_ray = {measured};
    }
}

}  // namespace sightline
