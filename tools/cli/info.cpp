#include "commands.h"
#include "core/text.h"
#include "options.h"
#include "output/environment_cache.h"
#include "output/render_asset.h"
#include "output/statistics.h"

#include <nlohmann/json.hpp>

#include <memory>

namespace sightline {
namespace {

struct InfoCli {
    RenderCommand command;
    bool json = false;
};

size_t count_triangles(const Scene& scene, bool placed) {
    size_t count = 0;
    if (!placed) {
        for (const Mesh& mesh : scene.meshes) count += mesh.triangles.size();
        return count;
    }
    for (const Instance& instance : scene.instances)
        for (const uint32_t m : scene.groups[instance.group].meshes)
            count += scene.meshes[m].triangles.size();
    return count;
}

nlohmann::ordered_json item_names(const auto& items) {
    auto names = nlohmann::ordered_json::array();
    for (const auto& item : items) names.push_back(item.name);
    return names;
}

nlohmann::ordered_json animations_of(const FileContents& contents) {
    auto animations = nlohmann::ordered_json::array();
    for (const auto& [name, seconds] : contents.animations)
        animations.push_back({{"name", name}, {"seconds", seconds}});
    return animations;
}

nlohmann::ordered_json world_point(const Scene& scene, const Vec3& p) {
    if (scene.frame.is_identity()) return {p.x, p.y, p.z};
    const Vec3d world = scene.frame.leave(Vec3d(p));
    return {world.x, world.y, world.z};
}

nlohmann::ordered_json describe(const Scene& scene, const Needs& needs) {
    using nlohmann::ordered_json;
    ordered_json json = {
        {"asset", scene.path},
        {"hash", fmt::format("{:016x}", scene.content_hash)},
        {"triangles", count_triangles(scene, false)},
        {"triangles_placed", count_triangles(scene, true)},
        {"meshes", scene.meshes.size()},
        {"shapes", scene.shapes.size()},
        {"instances", scene.instances.size()},
        {"materials", item_names(scene.materials)},
        {"textures", scene.textures.size()},
        {"images", scene.images.size()},
        {"lights", item_names(scene.lights)},
        {"cameras", item_names(scene.cameras)},
        {"scenes", scene.contents.scenes},
        {"variants", scene.contents.variants},
        {"animations", animations_of(scene.contents)},
        {"extensions", scene.contents.extensions},
        {"warnings", scene.warnings},
        {"fault_count", scene.fault_count},
        {"faults", faults_json(scene.faults)},
    };
    if (!scene.bounds.isEmpty()) {
        json["bounds"] = {world_point(scene, scene.bounds.min),
                          world_point(scene, scene.bounds.max)};
    }
    if (!scene.frame.is_identity()) {
        const Vec3d& o = scene.frame.origin;
        json["coordinates"] = {{"origin", {o.x, o.y, o.z}}, {"scale", scene.frame.scale}};
    }
    for (const Decision& decision : needs.report)
        json["needs"][decision.name] = {{"choice", decision.choice}, {"because", decision.because}};
    return json;
}

void print_text(const nlohmann::ordered_json& json) {
    for (const auto& [key, value] : json.items()) {
        if (key == "needs" || key == "warnings" || key == "faults") continue;
        fmt::print(
            "{:<18} {}\n", key,
            printable(value.is_string()
                          ? value.get<std::string>()
                          : value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)));
    }
    fmt::print("\nneeds\n");
    if (json.contains("needs"))
        for (const auto& [name, need] : json["needs"].items())
            fmt::print("  {:<16} {:<8} {}\n", name, need["choice"].get<std::string>(),
                       need["because"].get<std::string>());
    for (const auto& warning : json["warnings"])
        fmt::print("warning: {}\n", printable(warning.get<std::string>()));
}

void run(InfoCli& cli) {
    RenderCommand& command = cli.command;
    check_view(command.view);
    command.load.decode_images = false;
    command.load.find_all_faults = true;
    const Scene scene = load_gltf(command.asset, command.load);
    const bool lit = choose_environment(command.light, scene) != "none";
    const auto json = describe(scene, find_needs(scene, complete_settings(command, scene), lit));
    if (cli.json) {
        fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
    } else {
        print_text(json);
    }
}

}  // namespace

void add_info_command(CLI::App& app) {
    const auto cli = std::make_shared<InfoCli>();
    RenderCommand& command = cli->command;
    CLI::App* sub = app.add_subcommand(
        "info", "List a file's contents, the features that rendering it needs, and warnings");
    add_scene_argument(*sub, command.asset);
    add_load_options(*sub, command.load);
    begin_group(*sub, "Options of render that change the needs");
    add_camera_options(*sub, command.view);
    add_aperture_option(*sub, command.settings);
    add_environment_option(*sub, command.light);
    add_transport_options(*sub, command.settings);
    begin_group(*sub, "Other");
    sub->add_flag("--json", cli->json, "Print JSON");
    sub->footer("Try `sightline info asset.glb`.");
    sub->callback([cli] { run(*cli); });
}

}  // namespace sightline
