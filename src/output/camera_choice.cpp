#include "output/camera_choice.h"

#include "core/error.h"
#include "core/suggest.h"
#include "core/text.h"
#include "scene/camera_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace sightline {
namespace {

Vec3 centre_of(const Scene& scene) {
    return scene.bounds.isEmpty() ? Vec3(0, 0, 0) : scene.bounds.center();
}

Camera find_camera(const Scene& scene, const std::string& name_or_index) {
    std::vector<std::string> names;
    for (const Camera& camera : scene.cameras) names.push_back(camera.name);
    if (const auto found = find_choice(names, name_or_index)) {
        const Camera& camera = scene.cameras[*found];
        if (camera.fault.empty()) return camera;
        throw Error(fmt::format("{}: {}; `fit` frames the scene", scene.path, camera.fault));
    }
    std::vector<std::string> candidates = names;
    std::ranges::copy(view_names(), std::back_inserter(candidates));
    throw Error(fmt::format(
        "{}: there is no camera \"{}\"; the file has {}; the views that frame the scene are {}{}",
        scene.path, name_or_index, list_choices(names), describe_views(),
        did_you_mean(name_or_index, candidates)));
}

Camera base_camera(const ViewOptions& options, const Scene& scene) {
    if (options.look_from || options.look_at) {
        const auto place = [&](const std::optional<Vec3d>& given, const Vec3& otherwise) {
            return given ? Vec3(scene.frame.enter(*given)) : otherwise;
        };
        const Vec3 centre = centre_of(scene);
        const Vec3 in_front = centre + Vec3(0, 0, static_cast<float>(scene.frame.scale));
        return look_at(place(options.look_from, in_front), place(options.look_at, centre),
                       options.up.value_or(Vec3(0, 1, 0)), pi / 4);
    }
    if (options.camera.empty()) {
        const auto first = std::ranges::find(scene.cameras, "", &Camera::fault);
        return first == scene.cameras.end() ? fit_camera(scene.bounds) : *first;
    }
    if (const auto angles = find_view(options.camera)) return fit_camera(scene.bounds, *angles);
    return find_camera(scene, options.camera);
}

}  // namespace

Camera choose_camera(const ViewOptions& options, const Scene& scene) {
    Camera camera = base_camera(options, scene);
    if (options.fov) {
        camera.yfov = *options.fov * pi / 180;
        camera.aspect = 0;  // the picture's: the file's aspect belongs to the file's field of view
    }
    if (options.orbit != 0) {
        const Vec3 centre = centre_of(scene);
        camera.to_world *= Mat4().setTranslation(-centre) *
                           Mat4().setAxisAngle(Vec3(0, 1, 0), options.orbit * pi / 180) *
                           Mat4().setTranslation(centre);
    }
    return camera;
}

}  // namespace sightline
