#include "lab/compare/compare_report.h"

#include "core/files.h"
#include "image/write_image.h"
#include "lab/charts.h"
#include "lab/compare/ray_file.h"
#include "output/web_page.h"

#include <fmt/format.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <set>

namespace sightline {

/// compare_report.html as it stands in the source tree; the build makes this of it.
extern const char* const compare_report_html;

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr size_t worst_of_each = 12;

/// How bad a verdict is: the least first.
int rank(Verdict verdict) {
    constexpr Verdict order[] = {Verdict::missed,      Verdict::false_hit, Verdict::wrong_primitive,
                                 Verdict::undecidable, Verdict::near_tie,  Verdict::unjudged};
    return static_cast<int>(std::ranges::find(order, verdict) - std::begin(order));
}

/// The rays worth a look: the worst findings of each engine, and where its t is farthest off.
std::vector<uint32_t> worst_rays(const Comparison& comparison) {
    std::vector<uint32_t> worst;
    std::set<uint32_t> seen;
    const auto take = [&](uint32_t ray) {
        const bool fresh = ray != none && seen.insert(ray).second;
        if (fresh) worst.push_back(ray);
        return fresh;
    };
    std::vector<RayFinding> findings = comparison.findings;
    std::ranges::stable_sort(findings, {}, [](const RayFinding& f) { return rank(f.verdict); });
    std::vector<size_t> taken(comparison.engines.size());
    for (const RayFinding& finding : findings)
        if (taken[finding.engine] < worst_of_each) taken[finding.engine] += take(finding.ray);
    for (const EngineScore& engine : comparison.engines)
        for (const KindScore& kind : engine.kinds) take(kind.worst_t_ray);
    return worst;
}

json surface_json(const SurfaceId& id) { return {id.instance, id.geometry, id.primitive}; }

json ray_json(const Scene& scene, const Referee& referee, const RecordedRay& recorded,
              std::span<const Engine> engines) {
    const RayReport report = inspect(scene, referee, engines, recorded.ray);
    const bool shadow = recorded.kind == RayKind::shadow;
    json record = {{"ray", ray_literal(recorded.ray)},
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
            entry["blocked"] = answer.blocked;
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

/// Ours, Embree's and the referee's view; then what each engine got wrong.
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
    nlohmann::ordered_json results = comparison_json(comparison, context);
    json worst = json::array();
    for (const uint32_t ray : worst_rays(comparison))
        worst.push_back(ray_json(scene, referee, rays[ray], engines));
    results["worst"] = worst;
    json page = results;
    page["replay"] = context.replay;
    page["maps"] = maps_json(folder, comparison, referee, rays, engines, context);
    for (size_t e = 0; e < comparison.engines.size(); ++e) {
        const Tally total = comparison.engines[e].total();
        page["methods"][e]["rate"] = per_million(total.wrong(), total.judged());
        for (size_t k = 0; k < ray_kinds; ++k) {
            const Tally& tally = comparison.engines[e].kinds[k].tally;
            page["methods"][e]["kinds"][ray_kind_names[k]]["rate"] =
                per_million(tally.wrong(), tally.judged());
        }
    }
    write_text(folder + "/results.json",
               results.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
    write_text(folder + "/results.csv", comparison_csv(comparison));
    write_report_page(folder, compare_report_html, page);
}

}  // namespace sightline
