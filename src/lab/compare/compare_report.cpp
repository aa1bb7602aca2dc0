#include "lab/compare/compare_report.h"

#include "core/files.h"
#include "core/version.h"
#include "image/write_image.h"
#include "lab/charts.h"
#include "lab/compare/compare_tables.h"
#include "lab/compare/worst_rays.h"
#include "lab/machine.h"
#include "output/web_page.h"

#include <fmt/format.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>

namespace sightline {

/// The text of compare_report.html, compiled in by the build.
extern const char* const compare_report_html;

namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

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
                           {"summary", summary_sentences(comparison, context.scene)},
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
    results["worst"] = worst_rays_json(comparison, scene, referee, rays, engines);
    ordered_json page = results;
    page["replay"] = context.replay;
    page["maps"] = maps_json(folder, comparison, referee, rays, engines, context);
    for (size_t e = 0; e < engines.size(); ++e)  // their rays cannot be replayed
        page["methods"][e]["foreign"] = engines[e].measured_ns.has_value();
    write_report(folder, {.results = results.dump(1, ' ', false, json::error_handler_t::replace),
                          .csv = comparison_csv(comparison),
                          .page = compare_report_html,
                          .data = page});
}

}  // namespace sightline
