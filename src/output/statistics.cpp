#include "output/statistics.h"

#include "core/memory.h"
#include "core/version.h"

#include <nlohmann/json.hpp>

namespace sightline {

nlohmann::json faults_json(std::span<const FoundFault> faults) {
    auto json = nlohmann::json::array();
    for (const FoundFault& fault : faults)
        json.push_back({{"key", fault.key}, {"place", fault.place}, {"text", fault.text}});
    return json;
}

std::array<std::pair<const char*, double>, 9> stages_of(const StageTimes& s) {
    return {{{"open", s.open},
             {"parse", s.parse},
             {"pose", s.pose},
             {"decode", s.decode},
             {"build", s.build},
             {"prepare", s.prepare},
             {"trace", s.trace},
             {"shade", s.shade},
             {"write", s.write}}};
}

std::string statistics_json(const RenderCommand& command, const AssetResult& result) {
    using nlohmann::ordered_json;
    const Counters& c = result.picture.counters;
    uint64_t rays = 0;
    for (const uint64_t n : c.rays) rays += n;
    ordered_json needs = ordered_json::array();
    for (const Decision& decision : result.needs.report)
        needs.push_back({{"name", decision.name},
                         {"choice", decision.choice},
                         {"because", decision.because},
                         {"saves", decision.saves}});
    const StageTimes& s = result.seconds;
    ordered_json seconds;
    for (const auto& [stage, time] : stages_of(s)) seconds[stage] = time;
    seconds["load"] = s.load();
    seconds["render"] = s.render;
    seconds["total"] = s.total;
    const ordered_json json = {
        {"version", program_version},
        {"asset", command.asset},
        {"outputs", command.output.pictures},
        {"seconds", seconds},
        {"bytes",
         {{"files", result.bytes.files},
          {"images", result.bytes.images},
          {"whole_images", result.bytes.whole_images},
          {"pyramids", result.bytes.pyramids}}},
        {"finer_lookups", result.finer_lookups},
        {"rays",
         {{"camera", c.rays[0]},
          {"shadow", c.rays[1]},
          {"reflection", c.rays[2]},
          {"refraction", c.rays[3]}}},
        {"rays_per_second", s.render > 0 ? static_cast<double>(rays) / s.render : 0},
        {"samples", c.samples},
        {"cut_rays", c.cut_rays},
        {"depth_reached", c.depth_reached},
        {"coloured_shadow_rays", c.coloured_shadow_rays},
        {"uncovered_hits", c.uncovered_hits},
        {"absorbed_rays", c.absorbed_rays},
        {"peak_memory_bytes", peak_memory()},
        {"scene_bytes", result.scene_bytes},
        {"intersector_bytes", result.intersector_bytes},
        {"threads", result.threads},
        {"intersector", result.intersector},
        {"complete", !result.interrupted},
        {"picture", to_string(result.content)},
        {"needs", needs},
        {"paid_but_unused", unused_needs(result.needs, c)},
        {"warnings", result.warnings},
        {"fault_count", result.fault_count},
        {"faults", faults_json(result.faults)},
    };
    // JSON is UTF-8; paths and names need not be.
    return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

size_t scene_memory(const Scene& scene) {
    size_t bytes = 0;
    const auto add = [&](const auto& array) { bytes += array.size() * sizeof(array[0]); };
    for (const Mesh& mesh : scene.meshes) {
        add(mesh.positions), add(mesh.normals), add(mesh.tangents), add(mesh.colors);
        add(mesh.triangles);
        for (const auto& set : mesh.texcoords) add(set);
    }
    for (const Image& image : scene.images) bytes += image.memory();
    add(scene.instances), add(scene.shapes), add(scene.materials);
    return bytes;
}

}  // namespace sightline
