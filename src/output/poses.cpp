#include "output/poses.h"

#include "core/error.h"
#include "core/text.h"
#include "render/cryptomatte.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

// The matrix for column vectors, row by row.
ordered_json matrix_json(const Mat4d& rows) {
    ordered_json matrix = ordered_json::array();
    for (int r = 0; r < 4; ++r) matrix.push_back({rows[0][r], rows[1][r], rows[2][r], rows[3][r]});
    return matrix;
}

ordered_json vector_json(const Vec3d& v) { return {v.x, v.y, v.z}; }

// As seen from the folder of the poses' file.
std::string relative_name(const std::string& file, const std::string& poses) {
    const fs::path folder = fs::absolute(poses).parent_path();
    return fs::absolute(file).lexically_normal().lexically_proximate(folder.lexically_normal());
}

ordered_json intrinsics_json(const CameraPose& pose) {
    return {{"w", pose.width},
            {"h", pose.height},
            {"fl_x", pose.focal_x},
            {"fl_y", pose.focal_y},
            {"cx", pose.centre_x},
            {"cy", pose.centre_y},
            {"camera_angle_x", 2 * std::atan(pose.width / (2 * pose.focal_x))},
            {"camera_angle_y", 2 * std::atan(pose.height / (2 * pose.focal_y))}};
}

ordered_json view_json(const std::string& path, const PosedPicture& picture) {
    const CameraPose& pose = picture.pose;
    ordered_json files = ordered_json::array(), layers = ordered_json::object();
    for (const std::string& file : picture.files) files.push_back(relative_name(file, path));
    for (const auto& [layer, file] : picture.data_files) {
        const DataScale& scale = picture.data_scales.at(layer);
        layers[layer] = {
            {"file", relative_name(file, path)}, {"scale", scale.scale}, {"zero", scale.zero}};
    }
    return {{"view", picture.view},
            {"frame", picture.frame},
            {"files", files},
            {"layers", layers},
            {"projection", pose.orthographic ? "orthographic" : "perspective"},
            {"width", pose.width},
            {"height", pose.height},
            {"focal", {pose.focal_x, pose.focal_y}},
            {"centre", {pose.centre_x, pose.centre_y}},
            {"camera_to_world", matrix_json(pose.to_world)}};
}

ordered_json sightline_form(const std::string& path, const Scene& scene,
                            const std::vector<PosedPicture>& pictures) {
    ordered_json views = ordered_json::array();
    for (const PosedPicture& picture : pictures) views.push_back(view_json(path, picture));
    return {
        {"format", "sightline-poses"},
        {"version", 1},
        {"asset", scene.path},
        {"world", "right-handed, +y up, in units of the asset, relative to origin"},
        {"camera", "right-handed, +x right, +y up, looks along -z"},
        {"pixels", "from the upper left corner, y down; centre of the first at 0.5, 0.5"},
        {"origin", vector_json(pictures.empty() ? Vec3d(0) : pictures[0].pose.origin)},
        {"objects", object_names(scene)},
        {"materials", material_names(scene)},
        {"views", views},
    };
}

ordered_json transforms_form(const std::string& path, PosesForm form,
                             const std::vector<PosedPicture>& pictures) {
    ordered_json json = {{"camera_model", "PINHOLE"}}, frames = ordered_json::array();
    const ordered_json shared = intrinsics_json(pictures.at(0).pose);
    const bool same = std::ranges::all_of(pictures, [&](const PosedPicture& picture) {
        return intrinsics_json(picture.pose) == shared;
    });
    if (same) json.update(shared);
    for (const PosedPicture& picture : pictures) {
        if (picture.pose.orthographic)
            throw Error(
                fmt::format("{}: transforms.json has no orthographic cameras; use "
                            "--poses-form sightline",
                            path));
        fs::path file = relative_name(picture.files.at(0), path);
        if (form == PosesForm::blender) file.replace_extension();
        ordered_json frame = {{"file_path", "./" + file.string()}};
        for (const auto& [layer, key] :
             {std::pair("depth", "depth_file_path"), std::pair("mask", "mask_path"),
              std::pair("normal", "normal_file_path")})
            if (const auto found = picture.data_files.find(layer);
                found != picture.data_files.end())
                frame[key] = "./" + relative_name(found->second, path);
        if (const auto depth = picture.data_scales.find("depth");
            depth != picture.data_scales.end())
            frame["depth_scale"] = depth->second.scale;
        if (!same) frame.update(intrinsics_json(picture.pose));
        frame["transform_matrix"] = matrix_json(picture.pose.to_world);
        frames.push_back(frame);
    }
    json["origin"] = vector_json(pictures.at(0).pose.origin);
    json["frames"] = frames;
    return json;
}

}  // namespace

CameraPose pose_of(const RenderContext& context) {
    const RenderSettings& settings = context.settings;
    const Frame& frame = context.scene.frame;
    const PixelRect window = context.layers.layout.window;
    const Vec2 half = context.camera.half_size();
    CameraPose pose;
    pose.orthographic = settings.camera.orthographic;
    pose.width = window.width();
    pose.height = window.height();
    // Orthographic lengths are those of the scene's frame.
    const double unit = pose.orthographic ? frame.scale : 1.0;
    pose.focal_x = settings.width / (2 * double(half.x)) * unit;
    pose.focal_y = settings.height / (2 * double(half.y)) * unit;
    pose.centre_x = settings.width / 2.0 - window.x0;
    pose.centre_y = settings.height / 2.0 - window.y0;
    pose.to_world = Mat4d(settings.camera.to_world);
    for (int c = 0; c < 3; ++c) pose.to_world[3][c] /= frame.scale;
    pose.origin = frame.origin;
    return pose;
}

std::string poses_json(const std::string& path, PosesForm form, const Scene& scene,
                       const std::vector<PosedPicture>& pictures) {
    const ordered_json json = form == PosesForm::sightline ? sightline_form(path, scene, pictures)
                                                           : transforms_form(path, form, pictures);
    return json.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace sightline
