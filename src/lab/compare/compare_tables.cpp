// The comparison as text: JSON, CSV, a table.
#include "core/version.h"
#include "lab/compare/compare_report.h"
#include "lab/compare/ray_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace sightline {
namespace {

using nlohmann::ordered_json;

ordered_json quantiles_json(const Quantiles& q) {
    if (q.count() == 0) return nullptr;
    return {{"median", q.at(0.5)}, {"p999", q.at(0.999)}, {"max", q.max()}};
}

std::optional<double> median_time(const KindScore& kind) {
    if (kind.ns_per_ray.empty()) return std::nullopt;
    return kind.ns_per_ray[kind.ns_per_ray.size() / 2];
}

ordered_json kind_json(const KindScore& kind) {
    ordered_json json = to_json(kind.tally);
    const auto time = median_time(kind);
    json["ns_per_ray"] = time ? ordered_json(*time) : ordered_json(nullptr);
    json["ns_per_ray_rounds"] = kind.ns_per_ray;
    if (kind.instructions_per_ray) json["instructions_per_ray"] = *kind.instructions_per_ray;
    json["barycentric_error"] = quantiles_json(kind.barycentrics);
    json["normal_angle_degrees"] = quantiles_json(kind.normal_angle);
    return json;
}

/// The mean over all rays of the kinds' medians.
std::optional<double> mean_time(const EngineScore& engine) {
    double sum = 0;
    uint64_t rays = 0;
    for (const KindScore& kind : engine.kinds)
        if (const auto time = median_time(kind)) {
            sum += *time * static_cast<double>(kind.tally.rays());
            rays += kind.tally.rays();
        }
    if (rays == 0) return std::nullopt;
    return sum / static_cast<double>(rays);
}

ordered_json engine_json(const EngineScore& engine) {
    ordered_json json = {{"name", engine.name},
                         {"description", engine.description},
                         {"memory_bytes", engine.memory}};
    for (size_t k = 0; k < ray_kinds; ++k)
        json["kinds"][ray_kind_names[k]] = kind_json(engine.kinds[k]);
    ordered_json& total = json["total"] = to_json(engine.total());
    const auto time = mean_time(engine);
    total["ns_per_ray"] = time ? ordered_json(*time) : ordered_json(nullptr);
    return json;
}

/// Calls row(engine, kind's name, tally, time) for each kind that has rays, and for their sum.
template <class Row>
void for_each_row(const Comparison& comparison, const Row& row) {
    for (const EngineScore& engine : comparison.engines) {
        for (size_t k = 0; k < ray_kinds; ++k)
            if (comparison.rays[k] > 0)
                row(engine.name, ray_kind_names[k], engine.kinds[k].tally,
                    median_time(engine.kinds[k]));
        row(engine.name, "total", engine.total(), mean_time(engine));
    }
}

std::string surface_text(const SurfaceId& id) {
    return fmt::format("instance {} geometry {} primitive {}", id.instance, id.geometry,
                       id.primitive);
}

}  // namespace

ordered_json comparison_json(const Comparison& comparison, const ReportContext& context) {
    ordered_json json = {{"version", program_version},
                         {"command", context.command},
                         {"scene", context.picture},
                         {"production", context.production},
                         {"max_wrong_per_million", context.max_wrong},
                         {"invalid_rays", comparison.invalid_rays}};
    for (size_t k = 0; k < ray_kinds; ++k) json["rays"][ray_kind_names[k]] = comparison.rays[k];
    json["methods"] = ordered_json::array();
    for (const EngineScore& engine : comparison.engines)
        json["methods"].push_back(engine_json(engine));
    return json;
}

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
    std::string text =
        fmt::format("{:<24} {:<10} {:>9} {:>8} {:>7} {:>7} {:>7} {:>8} {:>8} {:>8} {:>8} {:>8}\n",
                    "method", "rays", "", "tie", "missed", "false", "wrong", "near-tie", "undecid.",
                    "unjudged", "ns/ray", "t ulps");
    for_each_row(comparison, [&](const std::string& name, const char* kind, const Tally& tally,
                                 std::optional<double> time) {
        const auto count = [&](Verdict v) { return tally[v]; };
        text += fmt::format(
            "{:<24} {:<10} {:>9} {:>8} {:>7} {:>7} {:>7} {:>8} {:>8} {:>8} {:>8} {:>8.3g}\n", name,
            kind, tally.rays(), count(Verdict::tie), count(Verdict::missed),
            count(Verdict::false_hit), count(Verdict::wrong_primitive), count(Verdict::near_tie),
            count(Verdict::undecidable), count(Verdict::unjudged) + tally.unchecked,
            time ? fmt::format("{:.0f}", *time) : "-", tally.t_ulps.max());
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
        text += truth.complete ? "exactly  nothing\n" : "exactly  not known\n";
    else
        text += fmt::format("exactly  t {:.17g} ({:a}){}\n", truth.t, truth.t,
                            truth.nearest.size() > 1 ? ", several at once" : "");
    for (const SurfaceId& id : truth.nearest) text += "         " + surface_text(id) + "\n";
    for (size_t e = 0; e < engines.size(); ++e) {
        const EngineAnswer& answer = report.answers[e];
        text += fmt::format("{:<24} {:<16} ", engines[e].name, name_of(answer.verdict));
        text += answer.hit ? fmt::format("t {:a} ({:.3g} ulps) u {:.9g} v {:.9g}, {}", answer.hit.t,
                                         answer.t_ulps, answer.hit.u, answer.hit.v,
                                         surface_text(surface_of(answer.hit)))
                           : "nothing";
        text += fmt::format("; as a shadow ray {}: {}\n", answer.blocked ? "blocked" : "free",
                            name_of(answer.occlusion_verdict));
    }
    return text;
}

}  // namespace sightline
