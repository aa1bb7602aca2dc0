#include "lab/compare/compare_report.h"

#include "core/files.h"
#include "core/version.h"
#include "image/write_image.h"
#include "intersect/bvh/traversal_kernel.h"
#include "intersect/ray_file.h"
#include "lab/charts.h"
#include "lab/compare/compare_tables.h"
#include "output/web_page.h"

#include <fmt/format.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

namespace sightline {

/// The text of compare_report.html, compiled in by the build.
extern const char* const compare_report_html;

namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

constexpr size_t max_findings = 12;  // of each engine

ordered_json quantiles_json(const Quantiles& q) {
    if (q.count() == 0) return nullptr;
    return {{"median", q.at(0.5)}, {"p999", q.at(0.999)}, {"max", q.max()}};
}

ordered_json kind_json(const KindScore& kind) {
    ordered_json fields = to_json(kind.tally);
    const auto time = kind.median_ns();
    fields["ns_per_ray"] = time ? ordered_json(*time) : ordered_json(nullptr);
    fields["ns_per_ray_rounds"] = kind.ns_per_ray;
    if (kind.instructions_per_ray) fields["instructions_per_ray"] = *kind.instructions_per_ray;
    if (kind.wrapper)
        fields["wrapper"] = {{"library_call", kind.wrapper->library_call},
                             {"library_ns_per_ray", kind.wrapper->bare_ns},
                             {"factor", kind.wrapper->factor}};
    fields["barycentric_error"] = quantiles_json(kind.barycentrics);
    fields["normal_angle_degrees"] = quantiles_json(kind.normal_angle);
    return fields;
}

/// The processor's name, its threads, and the vectors that our engines use.
ordered_json machine_json() {
    std::ifstream file("/proc/cpuinfo");
    std::string processor = "unknown processor";
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name")) {
            processor = line.substr(std::min(line.size(), line.find(':') + 2));
            break;
        }
    return {{"processor", processor},
            {"threads", std::thread::hardware_concurrency()},
            {"vectors", vector_target()}};
}

ordered_json engine_json(const EngineScore& engine) {
    ordered_json fields = {{"name", engine.name},
                           {"description", engine.description},
                           {"memory_bytes", engine.memory},
                           {"left_out", engine.warnings}};
    for (size_t k = 0; k < ray_kinds; ++k)
        fields["kinds"][ray_kind_names[k]] = kind_json(engine.kinds[k]);
    ordered_json& total = fields["total"] = to_json(engine.total());
    const auto time = engine.mean_ns();
    total["ns_per_ray"] = time ? ordered_json(*time) : ordered_json(nullptr);
    return fields;
}

/// The contents of results.json (docs/compare.md lists the fields), without the worst rays.
ordered_json comparison_json(const Comparison& comparison, const ReportContext& context) {
    ordered_json fields = {{"version", program_version},
                           {"command", context.command},
                           {"scene", context.scene},
                           {"summary", summary_sentences(comparison)},
                           {"notes", comparison.notes},
                           {"machine", machine_json()},
                           {"production", context.production},
                           {"max_wrong_per_million", context.max_wrong},
                           {"invalid_rays", comparison.invalid_rays},
                           {"rays_left", comparison.rays_left}};
    for (size_t k = 0; k < ray_kinds; ++k) fields["rays"][ray_kind_names[k]] = comparison.rays[k];
    fields["methods"] = ordered_json::array();
    for (const EngineScore& engine : comparison.engines)
        fields["methods"].push_back(engine_json(engine));
    return fields;
}

/// Orders verdicts from the worst to the least severe.
int rank(Verdict verdict) {
    constexpr Verdict order[] = {Verdict::missed,   Verdict::false_hit, Verdict::wrong_primitive,
                                 Verdict::wrong_t,  Verdict::wrong_uv,  Verdict::undecidable,
                                 Verdict::near_tie, Verdict::unjudged};
    return static_cast<int>(std::ranges::find(order, verdict) - std::begin(order));
}

/// The rays to report: the worst findings of each engine, and those with its largest errors of t.
std::vector<uint32_t> worst_rays(const Comparison& comparison) {
    std::vector<uint32_t> worst;
    std::set<uint32_t> added;
    const auto add = [&](uint32_t ray) {
        const bool is_new = ray != none && added.insert(ray).second;
        if (is_new) worst.push_back(ray);
        return is_new;
    };
    std::vector<RayFinding> findings = comparison.findings;
    std::ranges::stable_sort(findings, {}, [](const RayFinding& f) { return rank(f.verdict); });
    std::vector<size_t> count(comparison.engines.size());
    for (const RayFinding& finding : findings)
        if (count[finding.engine] < max_findings) count[finding.engine] += add(finding.ray);
    for (const EngineScore& engine : comparison.engines)
        for (const KindScore& kind : engine.kinds) add(kind.worst_t_ray);
    return worst;
}

json surface_json(const SurfaceId& id) { return {id.instance, id.geometry, id.primitive}; }

json ray_json(const Scene& scene, const Referee& referee, const RecordedRay& recorded,
              std::span<const Engine> engines) {
    const RayReport report = inspect(scene, referee, engines, recorded);
    const bool shadow = recorded.kind == RayKind::shadow;
    json record = {{"ray", ray_literal(recorded)},
                   {"kind", ray_kind_names[static_cast<size_t>(recorded.kind)]},
                   {"answers", json::array()},
                   {"truth", json::array()}};
    if (recorded.x >= 0) record["pixel"] = {recorded.x, recorded.y};
    for (const SurfaceId& id : report.truth.nearest) record["truth"].push_back(surface_json(id));
    if (!report.truth.nearest.empty()) record["t"] = report.truth.t;
    for (size_t e = 0; e < engines.size(); ++e) {
        const EngineAnswer& answer = report.answers[e];
        json entry = {{"verdict", name_of(shadow ? answer.occlusion_verdict : answer.verdict)}};
        if (shadow) {
            entry["blocked"] = answer.occluded;
        } else if (answer.hit) {
            entry["surface"] = surface_json(surface_of(answer.hit));
            entry["t"] = answer.hit.t;
            entry["t_ulps"] = answer.t_ulps;
            entry["normal_angle"] = answer.normal_angle;
        }
        record["answers"].push_back(entry);
    }
    return record;
}

std::string png_uri(const std::string& folder, const Image& image) {
    const fs::path path =
        fs::path(folder) / fmt::format("{}map-{}.png", temporary_prefix, ::getpid());
    write_image(path.string(), image);
    const auto bytes = read_file(path.string(), uint64_t{1} << 32);
    fs::remove(path);
    return data_uri("image/png", bytes);
}

/// Surfaces as reported by our first engine, by Embree's first and by the referee; then the
/// findings of each engine.
json maps_json(const std::string& folder, const Comparison& comparison, const Referee& referee,
               std::span<const RecordedRay> rays, std::span<const Engine> engines,
               const ReportContext& context) {
    if (context.rendered.empty()) return nullptr;
    std::vector<const Engine*> shown;
    for (const bool embree : {false, true}) {
        const auto found = std::ranges::find_if(
            engines, [&](const Engine& e) { return e.name.starts_with("embree") == embree; });
        if (found != engines.end()) shown.push_back(&*found);
    }
    json maps = {{"picture", png_uri(folder, context.rendered)},
                 {"surfaces", json::array()},
                 {"findings", json::array()}};
    for (const ScreenMap& map :
         surface_maps(referee, rays, shown, context.window, context.rendered))
        maps["surfaces"].push_back({{"name", map.name}, {"image", png_uri(folder, map.image)}});
    for (const ScreenMap& map : finding_maps(comparison, rays, context.window))
        maps["findings"].push_back({{"name", map.name}, {"image", png_uri(folder, map.image)}});
    return maps;
}

}  // namespace

void write_comparison(const std::string& folder, const Comparison& comparison, const Scene& scene,
                      const Referee& referee, std::span<const RecordedRay> rays,
                      std::span<const Engine> engines, const ReportContext& context) {
    ordered_json results = comparison_json(comparison, context);
    json worst = json::array();
    for (const uint32_t ray : worst_rays(comparison))
        worst.push_back(ray_json(scene, referee, rays[ray], engines));
    results["worst"] = worst;
    json page = results;
    page["replay"] = context.replay;
    page["maps"] = maps_json(folder, comparison, referee, rays, engines, context);
    for (size_t e = 0; e < comparison.engines.size(); ++e) {
        const Tally total = comparison.engines[e].total();
        page["methods"][e]["rate"] = per_million(total.wrong_rate());
        for (size_t k = 0; k < ray_kinds; ++k) {
            const Tally& tally = comparison.engines[e].kinds[k].tally;
            page["methods"][e]["kinds"][ray_kind_names[k]]["rate"] =
                per_million(tally.wrong_rate());
        }
    }
    write_text(folder + "/results.json",
               results.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
    write_text(folder + "/results.csv", comparison_csv(comparison));
    write_report_page(folder, compare_report_html, page);
}

}  // namespace sightline
