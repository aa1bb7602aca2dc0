#include "lab/compare/worst_rays.h"

#include "lab/compare/judging.h"
#include "shade/hit_geometry.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <set>

namespace sightline {
namespace {

using nlohmann::ordered_json;

constexpr size_t max_findings = 4;   // of each engine and verdict
constexpr float edge_width = 1e-4f;  // in barycentrics
constexpr double grazing_cosine = 1e-2;

/// From what an engine is most to blame for to what no engine is.
constexpr std::array causes = {"self_hit",    "shared",     "edge",         "grazing",
                               "other",       "inaccurate", "left_out",     "near_tie",
                               "undecidable", "unjudged",   "largest_error"};

/// From the worst to the least severe.
int rank(Verdict verdict) {
    constexpr Verdict order[] = {Verdict::missed,   Verdict::false_hit, Verdict::wrong_primitive,
                                 Verdict::wrong_t,  Verdict::wrong_uv,  Verdict::undecidable,
                                 Verdict::near_tie, Verdict::unjudged};
    return static_cast<int>(std::ranges::find(order, verdict) - std::begin(order));
}

/// The verdict on the query that the ray was recorded for.
Verdict verdict_of(const EngineAnswer& answer, RayKind kind) {
    return kind == RayKind::shadow ? answer.occlusion_verdict : answer.verdict;
}

bool is_beside_edge(const Hit& hit) {
    return std::min({hit.u, hit.v, 1 - hit.u - hit.v}) < edge_width;
}

bool is_grazing(const Scene& scene, const Ray& ray, const Hit& hit) {
    const Vec3d normal(hit_geometry(scene, hit, &ray, false).outward), direction(ray.direction);
    const double cosine = dot(normal, direction) / (normal.length() * direction.length());
    return std::abs(cosine) < grazing_cosine;
}

/// Where on their surfaces the true hit and the one that was answered lie.
std::string place_of(const Scene& scene, const Ray& ray, const Truth& truth,
                     const EngineAnswer& answer) {
    if (truth.nearest.size() > 1) return "shared";
    std::vector<Hit> hits;
    if (answer.hit) hits.push_back(answer.hit);
    if (!truth.nearest.empty())
        hits.push_back(compute_exact_hit(scene, ray, truth, truth.nearest[0]));
    const auto any = [&](const auto& test) { return std::ranges::any_of(hits, test); };
    if (any([&](const Hit& h) { return scene.is_mesh(h.geometry) && is_beside_edge(h); }))
        return "edge";
    return any([&](const Hit& h) { return is_grazing(scene, ray, h); }) ? "grazing" : "other";
}

/// The rays to report, in ascending order.
std::set<uint32_t> choose_rays(const Comparison& comparison) {
    std::set<uint32_t> chosen;
    std::vector<std::array<size_t, verdicts>> count(comparison.engines.size());
    for (const RayFinding& finding : comparison.findings) {
        size_t& found = count[finding.engine][static_cast<size_t>(finding.verdict)];
        if (found < max_findings && chosen.insert(finding.ray).second) ++found;
    }
    for (const EngineScore& engine : comparison.engines)
        for (const KindScore& kind : engine.kinds)
            if (kind.worst_t_ray != none) chosen.insert(kind.worst_t_ray);
    return chosen;
}

ordered_json surface_json(const SurfaceId& id) { return {id.instance, id.geometry, id.primitive}; }

ordered_json answer_json(const EngineAnswer& answer, RayKind kind) {
    ordered_json entry = {{"verdict", name_of(verdict_of(answer, kind))}};
    if (kind == RayKind::shadow) {
        entry["blocked"] = answer.occluded;
    } else if (answer.hit) {
        entry["surface"] = surface_json(surface_of(answer.hit));
        entry["t"] = answer.hit.t;
        entry["t_ulps"] = answer.t_ulps;
        entry["normal_angle"] = answer.normal_angle;
    }
    return entry;
}

ordered_json ray_json(const Scene& scene, const Referee& referee, const RecordedRay& recorded,
                      std::span<const Engine> engines) {
    const RayReport report = inspect(scene, referee, engines, recorded);
    const auto severity = [&](const EngineAnswer& answer) {
        return rank(verdict_of(answer, recorded.kind));
    };
    const auto worst = std::ranges::min_element(report.answers, {}, severity);
    const Engine& blamed = engines[static_cast<size_t>(worst - report.answers.begin())];
    ordered_json record = {{"cause", cause_of(scene, recorded, report.truth, *worst, blamed)},
                           {"ray", ray_literal(recorded)},
                           {"kind", ray_kind_names[static_cast<size_t>(recorded.kind)]}};
    if (recorded.x >= 0) record["pixel"] = {recorded.x, recorded.y};
    record["truth"] = ordered_json::array();
    for (const SurfaceId& id : report.truth.nearest) record["truth"].push_back(surface_json(id));
    if (!report.truth.nearest.empty()) record["t"] = report.truth.t;
    record["answers"] = ordered_json::array();
    for (const EngineAnswer& answer : report.answers)
        record["answers"].push_back(answer_json(answer, recorded.kind));
    return record;
}

}  // namespace

std::string cause_of(const Scene& scene, const RecordedRay& recorded, const Truth& truth,
                     const EngineAnswer& answer, const Engine& engine) {
    const Verdict verdict = verdict_of(answer, recorded.kind);
    if (verdict == Verdict::same || verdict == Verdict::tie) return "largest_error";
    if (!is_wrong(verdict)) return std::string(name_of(verdict));
    const Ray& ray = recorded.ray;
    if (!truth.nearest.empty() && engine.intersector->leaves_out(ray, truth.nearest[0]))
        return "left_out";
    if (verdict == Verdict::wrong_t || verdict == Verdict::wrong_uv) return "inaccurate";
    const bool leaves = recorded.kind != RayKind::camera;
    if (answer.hit && leaves &&
        (surface_of(answer.hit) == recorded.source || is_self_hit(ray, answer.hit)))
        return "self_hit";
    return place_of(scene, ray, truth, answer);
}

ordered_json worst_rays_json(const Comparison& comparison, const Scene& scene,
                             const Referee& referee, std::span<const RecordedRay> rays,
                             std::span<const Engine> engines) {
    std::vector<ordered_json> records;
    for (const uint32_t ray : choose_rays(comparison))
        records.push_back(ray_json(scene, referee, rays[ray], engines));
    std::ranges::stable_sort(records, {}, [](const ordered_json& record) {
        return std::ranges::find(causes, record["cause"].get<std::string>()) - causes.begin();
    });
    return records;
}

}  // namespace sightline
