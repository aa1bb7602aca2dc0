#include "lab/compare/compare_tables.h"

#include "intersect/ray_file.h"

#include <fmt/format.h>

namespace sightline {
namespace {

/// Calls row(engine, kind, tally, time) for each kind that has rays, and for the total.
template <class Row>
void for_each_row(const Comparison& comparison, const Row& row) {
    for (const EngineScore& engine : comparison.engines) {
        for (size_t k = 0; k < ray_kinds; ++k)
            if (comparison.rays[k] > 0)
                row(engine.name, ray_kind_names[k], engine.kinds[k].tally,
                    engine.kinds[k].median_ns());
        row(engine.name, "total", engine.total(), engine.mean_ns());
    }
}

std::string surface_text(const SurfaceId& id) {
    return fmt::format("instance {} geometry {} primitive {}", id.instance, id.geometry,
                       id.primitive);
}

}  // namespace

std::string comparison_csv(const Comparison& comparison) {
    std::string text = "method,kind,rays";
    for (size_t v = 0; v < verdicts; ++v)
        text += fmt::format(",{}", name_of(static_cast<Verdict>(v)));
    text += ",unchecked,wrong,self_hit,ns_per_ray,t_ulps_median,t_ulps_p999,t_ulps_max\n";
    for_each_row(comparison, [&](const std::string& name, const char* kind, const Tally& tally,
                                 std::optional<double> time) {
        text += fmt::format("{},{},{}", name, kind, tally.rays());
        for (const uint64_t count : tally.by_verdict) text += fmt::format(",{}", count);
        text += fmt::format(",{},{},{},{}", tally.unchecked, tally.wrong(), tally.self_hits,
                            time ? fmt::format("{:.1f}", *time) : "");
        const Quantiles& t = tally.t_ulps;
        text += t.count() == 0
                    ? ",,,\n"
                    : fmt::format(",{:.4g},{:.4g},{:.4g}\n", t.at(0.5), t.at(0.999), t.max());
    });
    return text;
}

std::string comparison_table(const Comparison& comparison) {
    std::string text = fmt::format(
        "{:<24} {:<10} {:>9} {:>8} {:>7} {:>7} {:>7} {:>7} {:>7} {:>8} {:>8} {:>8} "
        "{:>9} {:>8} {:>8}\n",
        "method", "rays", "", "tie", "missed", "false", "surface", "t", "u,v", "near-tie",
        "undecid.", "unjudged", "unchecked", "ns/ray", "t ulps");
    for_each_row(comparison, [&](const std::string& name, const char* kind, const Tally& tally,
                                 std::optional<double> time) {
        const auto count = [&](Verdict v) { return tally[v]; };
        text += fmt::format(
            "{:<24} {:<10} {:>9} {:>8} {:>7} {:>7} {:>7} {:>7} {:>7} {:>8} {:>8} {:>8} {:>9} {:>8} "
            "{:>8.3g}\n",
            name, kind, tally.rays(), count(Verdict::tie), count(Verdict::missed),
            count(Verdict::false_hit), count(Verdict::wrong_primitive), count(Verdict::wrong_t),
            count(Verdict::wrong_uv), count(Verdict::near_tie), count(Verdict::undecidable),
            count(Verdict::unjudged), tally.unchecked, time ? fmt::format("{:.0f}", *time) : "-",
            tally.t_ulps.max());
    });
    return text;
}

std::string ray_text(const Ray& ray, const RayReport& report, std::span<const Engine> engines) {
    const Truth& truth = report.truth;
    std::string text = fmt::format(
        "ray      {}\n         origin {:.9g} {:.9g} {:.9g}  direction "
        "{:.9g} {:.9g} {:.9g}  {:.9g} < t <= {:.9g}\n",
        ray_literal(ray), ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x,
        ray.direction.y, ray.direction.z, ray.tnear, ray.tfar);
    if (truth.nearest.empty())
        text += truth.complete ? "truth    nothing\n" : "truth    unknown\n";
    else
        text += fmt::format("truth    t {:.17g} ({:a}){}\n", truth.t, truth.t,
                            truth.nearest.size() > 1 ? ", several surfaces" : "");
    for (const SurfaceId& id : truth.nearest) text += "         " + surface_text(id) + "\n";
    for (size_t e = 0; e < engines.size(); ++e) {
        const EngineAnswer& answer = report.answers[e];
        text += fmt::format("{:<24} {:<16} ", engines[e].name, name_of(answer.verdict));
        text += answer.hit ? fmt::format("t {:a} ({:.3g} ulps) u {:.9g} v {:.9g}, {}", answer.hit.t,
                                         answer.t_ulps, answer.hit.u, answer.hit.v,
                                         surface_text(surface_of(answer.hit)))
                           : "nothing";
        text +=
            fmt::format("; as a shadow ray {}: {}\n", answer.occluded ? "occluded" : "not occluded",
                        name_of(answer.occlusion_verdict));
    }
    return text;
}

}  // namespace sightline
