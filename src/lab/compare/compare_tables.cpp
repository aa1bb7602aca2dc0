#include "lab/compare/compare_tables.h"

#include "intersect/ray_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

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

/// "a, b and c"
std::string listed(const std::vector<std::string>& items) {
    if (items.size() < 2) return items.empty() ? "no" : items[0];
    return fmt::format("{} and {}", fmt::join(items.begin(), items.end() - 1, ", "), items.back());
}

/// "embree: wrapper 1.04 × bare rtcIntersect16 (camera), 1.02 × rtcOccluded16 (shadow)", or "".
std::string wrapper_line(const EngineScore& engine) {
    std::vector<std::string> parts;
    for (size_t k = 0; k < ray_kinds; ++k)
        if (const auto& cost = engine.kinds[k].wrapper)
            parts.push_back(fmt::format("{:.2f} × bare {} ({})", cost->factor, cost->library_call,
                                        ray_kind_names[k]));
    if (parts.empty()) return "";
    return fmt::format("{}: wrapper {}\n", engine.name, fmt::join(parts, ", "));
}

/// "is wrong on 12 (340 per million) and misses 3"
std::string errors_of(const EngineScore& engine) {
    const Tally total = engine.total();
    std::string text = fmt::format("is wrong on {} ({} per million)", grouped(total.wrong()),
                                   per_million(total.wrong_rate()));
    if (total[Verdict::missed] > 0)
        text += fmt::format(", of which it misses {}", grouped(total[Verdict::missed]));
    return text;
}

/// The engines without errors.
std::string right_ones(const std::vector<std::string>& names, size_t engines) {
    constexpr size_t max_listed = 4;
    std::string text = listed(names) + (names.size() == 1 ? " is" : " are");
    if (names.size() > max_listed) {
        const bool exact = std::ranges::count(names, "exact") > 0;
        text = fmt::format("{} of the {}, {} among them, are", names.size(), engines,
                           exact ? "exact" : names[0]);
    }
    return text + " wrong on none of those that were judged";
}

/// Engines with errors besides the one that renders.
std::string wrong_ones(std::vector<const EngineScore*> engines) {
    std::ranges::stable_sort(engines, {}, [](const EngineScore* engine) {
        return engine->total().wrong_rate().estimate;
    });
    const auto& least = *engines.front();
    const auto& most = *engines.back();
    if (engines.size() == 1) return most.name + " " + errors_of(most);
    const auto rate = [](const EngineScore& engine) {
        Rate estimate = engine.total().wrong_rate();
        estimate.bounds = {estimate.estimate, estimate.estimate};
        return per_million(estimate);
    };
    return fmt::format("{} others are wrong on {} ({}) to {} ({}) per million", engines.size(),
                       rate(least), least.name, rate(most), most.name);
}

/// The first engine is the one that renders.
std::string who_is_right(const Comparison& comparison) {
    std::vector<std::string> right, parts;
    std::vector<const EngineScore*> wrong;
    for (const EngineScore& engine : comparison.engines)
        if (engine.total().wrong() == 0)
            right.push_back(engine.name);
        else if (&engine == &comparison.engines[0])
            parts.push_back(engine.name + ", which renders this scene, " + errors_of(engine));
        else
            wrong.push_back(&engine);
    if (!right.empty()) parts.insert(parts.begin(), right_ones(right, comparison.engines.size()));
    if (!wrong.empty()) parts.push_back(wrong_ones(wrong));
    return fmt::format("{}.", fmt::join(parts, "; "));
}

std::string who_is_fastest(const Comparison& comparison) {
    std::vector<std::pair<double, std::string>> times;
    for (const EngineScore& engine : comparison.engines)
        if (const auto ns = engine.mean_ns(); ns && engine.total().wrong() == 0)
            times.emplace_back(*ns, engine.name);
    std::ranges::sort(times);
    if (times.empty()) return "No engine without errors was timed.";
    std::string text =
        fmt::format("Of the engines without errors, {} is the fastest: {} ns a ray on one thread",
                    times[0].second, grouped(static_cast<uint64_t>(std::lround(times[0].first))));
    if (times.size() > 1)
        text += fmt::format("; {} takes {:.2f} times as long", times[1].second,
                            times[1].first / times[0].first);
    return text + ".";
}

}  // namespace

std::vector<std::string> summary_sentences(const Comparison& comparison, const std::string& scene) {
    uint64_t rays = 0;
    std::vector<std::string> kinds;
    for (size_t k = 0; k < ray_kinds; ++k) {
        rays += comparison.rays[k];
        if (comparison.rays[k] > 0)
            kinds.push_back(grouped(comparison.rays[k]) + " " + ray_kind_names[k]);
    }
    std::string what = fmt::format("{} engines answered the same {} rays of {}: {} rays.",
                                   comparison.engines.size(), grouped(rays),
                                   std::filesystem::path(scene).filename().string(), listed(kinds));
    if (comparison.rays_left > 0)
        what += fmt::format(" An interrupt left {} of them out.", grouped(comparison.rays_left));
    return {what, who_is_right(comparison), who_is_fastest(comparison)};
}

std::string comparison_csv(const Comparison& comparison) {
    std::string text = "method,kind,rays";
    for (size_t v = 0; v < verdicts; ++v)
        text += fmt::format(",{}", name_of(static_cast<Verdict>(v)));
    text += ",unchecked,wrong,left_out,self_hit,ns_per_ray,t_ulps_median,t_ulps_p999,t_ulps_max\n";
    for_each_row(comparison, [&](const std::string& name, const char* kind, const Tally& tally,
                                 std::optional<double> time) {
        text += fmt::format("{},{},{}", name, kind, tally.rays());
        for (const uint64_t count : tally.by_verdict) text += fmt::format(",{}", count);
        text += fmt::format(",{},{},{},{},{}", tally.unchecked, tally.wrong(), tally.left_out,
                            tally.self_hits, time ? fmt::format("{:.1f}", *time) : "");
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
        "{:>9} {:>8} {:>8} {:>8}\n",
        "method", "rays", "", "tie", "missed", "false", "surface", "t", "u,v", "near-tie",
        "undecid.", "unjudged", "unchecked", "left out", "ns/ray", "t ulps");
    for_each_row(comparison, [&](const std::string& name, const char* kind, const Tally& tally,
                                 std::optional<double> time) {
        const auto count = [&](Verdict v) { return tally[v]; };
        text += fmt::format(
            "{:<24} {:<10} {:>9} {:>8} {:>7} {:>7} {:>7} {:>7} {:>7} {:>8} {:>8} {:>8} {:>9} {:>8} "
            "{:>8} {:>8.3g}\n",
            name, kind, tally.rays(), count(Verdict::tie), count(Verdict::missed),
            count(Verdict::false_hit), count(Verdict::wrong_primitive), count(Verdict::wrong_t),
            count(Verdict::wrong_uv), count(Verdict::near_tie), count(Verdict::undecidable),
            count(Verdict::unjudged), tally.unchecked, tally.left_out,
            time ? fmt::format("{:.0f}", *time) : "-", tally.t_ulps.max());
    });
    for (const EngineScore& engine : comparison.engines) text += wrapper_line(engine);
    for (const EngineScore& engine : comparison.engines)
        for (const std::string& warning : engine.warnings)
            text += fmt::format("{}: {}\n", engine.name, warning);
    for (const std::string& note : comparison.notes) text += note + "\n";
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
