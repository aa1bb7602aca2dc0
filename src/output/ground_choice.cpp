#include "output/ground_choice.h"

#include "output/animation_points.h"
#include "scene/scene_extent.h"

#include <fmt/format.h>

#include <optional>

namespace sightline {
namespace {

/// The y of the lowest point that is visible, in all frames for which the scene is framed.
std::optional<double> lowest_point(const RenderCommand& command, const Scene& scene) {
    if (command.view.frame_for) return lowest_in_animation(command, scene.content_hash);
    const SceneExtent extent(scene);
    if (extent.is_empty()) return std::nullopt;
    return extent.farthest({Vec3d(0, -1, 0), std::nullopt}).y;
}

const char* name_of(GroundKind kind) {
    constexpr const char* names[] = {"none", "shadow", "cyclorama", "matte"};
    return names[static_cast<size_t>(kind)];
}

}  // namespace

GroundSettings choose_ground(const RenderCommand& command, const Scene& scene,
                             const Vec3& background) {
    const GroundOptions& options = command.ground;
    GroundSettings ground;
    if (options.kind == GroundKind::nothing) return ground;
    const std::optional<double> surface = options.height
                                              ? scene.frame.enter(Vec3d(0, *options.height, 0)).y
                                              : lowest_point(command, scene);
    if (!surface) return ground;
    const double size = scene.bounds.isEmpty() ? 0 : double(scene.bounds.size().length());
    ground.kind = options.kind;
    ground.height = static_cast<float>(*surface - ground_gap * size);
    ground.color = options.kind == GroundKind::cyclorama ? background : options.color;
    if (options.kind == GroundKind::shadow) ground.mirror = options.mirror;
    return ground;
}

Decision ground_decision(const GroundOptions& options, const GroundSettings& ground,
                         const Scene& scene) {
    const double height = scene.frame.leave(Vec3d(0, double(ground.height), 0)).y;
    return {"ground", name_of(ground.kind),
            fmt::format("at y = {:.6g}, {}", height,
                        options.height ? "as asked for" : "below the lowest point"),
            ""};
}

std::string ground_problem(const RenderCommand& command) {
    const GroundOptions& ground = command.ground;
    if (ground.kind == GroundKind::nothing && ground.height)
        return "--ground-height needs a ground, as in --ground shadow";
    if (ground.kind != GroundKind::shadow && ground.mirror != default_ground_mirror)
        return "--ground-mirror is for --ground shadow";
    const auto background = command.light.background;
    if (ground.kind == GroundKind::cyclorama && background && background != Background::color)
        return "--ground cyclorama becomes the background's colour: give --background a colour";
    return "";
}

}  // namespace sightline
