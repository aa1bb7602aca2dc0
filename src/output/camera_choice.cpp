#include "output/camera_choice.h"

#include "core/error.h"
#include "core/suggest.h"
#include "core/text.h"
#include "output/animation_points.h"
#include "scene/camera_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace sightline {
namespace {

Vec3 centre_of(const Scene& scene) {
    return scene.bounds.isEmpty() ? Vec3(0, 0, 0) : scene.bounds.center();
}

std::string describe_camera(const Scene& scene, size_t index) {
    const std::string& name = scene.cameras[index].name;
    return name.empty() ? fmt::format("the file's, {}", index)
                        : fmt::format("the file's, {} \"{}\"", index, name);
}

CameraChoice find_camera(const Scene& scene, const std::string& name_or_index) {
    std::vector<std::string> names;
    for (const Camera& camera : scene.cameras) names.push_back(camera.name);
    if (const auto found = find_choice(names, name_or_index)) {
        const Camera& camera = scene.cameras[*found];
        if (camera.fault.empty()) return {camera, describe_camera(scene, *found), "asked for"};
        throw Error(fmt::format("{}: {}; `fit` frames the scene", scene.path, camera.fault));
    }
    std::vector<std::string> candidates = names;
    std::ranges::copy(view_names(), std::back_inserter(candidates));
    throw Error(fmt::format(
        "{}: there is no camera \"{}\"; the file has {}; the views that frame the scene are {}{}",
        scene.path, name_or_index, list_choices(names), describe_views(),
        did_you_mean(name_or_index, candidates)));
}

Camera free_camera(const ViewOptions& options, const Scene& scene) {
    const auto place = [&](const std::optional<Vec3d>& given, const Vec3& otherwise) {
        return given ? Vec3(scene.frame.enter(*given)) : otherwise;
    };
    const Vec3 centre = centre_of(scene);
    const Vec3 in_front = centre + Vec3(0, 0, static_cast<float>(scene.frame.scale));
    return look_at(place(options.look_from, in_front), place(options.look_at, centre),
                   options.up.value_or(Vec3(0, 1, 0)), pi / 4);
}

// What the turn of --orbit is about.
void turn(Camera& camera, float degrees, const Vec3& centre) {
    camera.to_world *= Mat4().setTranslation(-centre) *
                       Mat4().setAxisAngle(Vec3(0, 1, 0), degrees * pi / 180) *
                       Mat4().setTranslation(centre);
}

Framing framing_of(const RenderCommand& command, const Scene& scene, const ViewAngles& angles) {
    const ViewOptions& view = command.view;
    const RenderSettings& settings = command.settings;
    Framing framing;
    framing.angles = angles;
    framing.orthographic = view.ortho;
    if (view.fov) framing.yfov = *view.fov * pi / 180;
    framing.aspect = static_cast<float>(settings.width) / static_cast<float>(settings.height);
    framing.margin = view.margin.value_or(default_margin) / 100;
    if (view.orbit && !view.frame_each) framing.turn_axis = centre_of(scene);
    if (view.orbit && view.frame_each) framing.angles.azimuth += double(*view.orbit);
    return framing;
}

Camera framed_camera(const RenderCommand& command, const Scene& scene, const ViewAngles& angles) {
    const ViewOptions& view = command.view;
    const Framing framing = framing_of(command, scene, angles);
    const Vec3 centre = centre_of(scene);
    Camera camera;
    if (view.frame_for && !view.frame_each) {
        const std::vector<Vec3d> points = animation_points(command, scene.content_hash, framing);
        camera =
            frame_camera([&](const Reach& reach) { return farthest_of(points, reach); }, framing);
    } else if (const SceneExtent extent(scene); extent.is_empty()) {
        camera = frame_camera([&](const Reach&) { return Vec3d(centre); }, framing);
    } else {
        camera = frame_camera([&](const Reach& reach) { return extent.farthest(reach); }, framing);
    }
    if (framing.turn_axis) turn(camera, *view.orbit, centre);
    return camera;
}

// Of a camera that does not frame the scene.
void apply_lens_and_orbit(const ViewOptions& options, const Scene& scene, Camera& camera) {
    if (options.fov) {
        camera.yfov = *options.fov * pi / 180;
        camera.aspect = 0;  // the picture's: the file's aspect belongs to the file's field of view
    }
    if (options.orbit) turn(camera, *options.orbit, centre_of(scene));
}

// The view that frames the scene, or else a camera.
CameraChoice choose(const ViewOptions& options, const Scene& scene) {
    if (options.look_from || options.look_at)
        return {free_camera(options, scene), "free", "--look-from or --look-at"};
    if (!options.camera.empty()) {
        if (!find_view(options.camera)) return find_camera(scene, options.camera);
        return {{}, options.camera, "asked for"};
    }
    if (options.ortho || options.margin || options.frame_each)
        return {{}, "fit", "--ortho, --margin or --frame-each"};
    const auto first = std::ranges::find(scene.cameras, "", &Camera::fault);
    if (first == scene.cameras.end()) return {{}, "fit", "the file has no camera"};
    const auto index = static_cast<size_t>(first - scene.cameras.begin());
    return {*first, describe_camera(scene, index),
            scene.cameras.size() == 1 ? "its only camera" : "its first camera"};
}

}  // namespace

CameraChoice choose_camera(const RenderCommand& command, const Scene& scene) {
    CameraChoice choice = choose(command.view, scene);
    const std::optional<ViewAngles> view = find_view(choice.name);
    if (view && choice.name != "fit-sphere") {
        choice.camera = framed_camera(command, scene, *view);
        return choice;
    }
    if (view) choice.camera = fit_camera(scene.bounds, *view);
    apply_lens_and_orbit(command.view, scene, choice.camera);
    return choice;
}

}  // namespace sightline
