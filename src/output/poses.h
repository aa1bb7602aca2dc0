#pragma once
// Where the cameras of pictures were, for programs that compute with them (docs/data_sets.md).
#include "output/data_layers.h"
#include "render/render_context.h"

#include <map>
#include <string>
#include <vector>

namespace sightline {

/// The camera of a picture. It looks along its -z axis, +x to the right, +y up. Pixels are counted
/// from the upper left corner of the picture's window, y down; the centre of the first is
/// (0.5, 0.5).
struct CameraPose {
    bool orthographic = false;
    int width = 0, height = 0;  ///< pixels
    /// Pixels: of a length at distance 1 or, if the camera is orthographic, of a length.
    double focal_x = 0, focal_y = 0;
    double centre_x = 0, centre_y = 0;  ///< where the camera's axis meets the picture, in pixels
    Mat4d to_world;                     ///< of row vectors; in world units, relative to `origin`
    Vec3d origin{0, 0, 0};
};

/// The pose of the camera that renders the context's picture.
CameraPose pose_of(const RenderContext& context);

/// A finished picture with its files and pose.
struct PosedPicture {
    std::string view;  ///< its name; empty if there are no views
    int frame = 0;
    std::vector<std::string> files;
    std::map<std::string, std::string> data_files;  ///< by layer
    std::map<std::string, DataScale> data_scales;   ///< by layer
    CameraPose pose;
};

/// How a file says poses.
enum class PosesForm {
    sightline,   ///< docs/data_sets.md
    nerfstudio,  ///< transforms.json of nerfstudio and instant-ngp
    blender      ///< the same with names without endings, of NeRF and Gaussian splatting
};

/// The poses of pictures of an asset, whose files are named relative to the folder of `path`.
/// `names`: of objects and materials, for layers of ids. Throws Error if the form has no
/// orthographic cameras and there is one.
std::string poses_json(const std::string& path, PosesForm form, const Scene& scene,
                       const std::vector<PosedPicture>& pictures);

}  // namespace sightline
