#pragma once
// Everything that one run of `render` needs, as one value per concern. Each stage takes only its
// own.
#include "core/progress.h"
#include "image/color_view.h"
#include "output/display.h"
#include "output/exr.h"
#include "render/render.h"
#include "scene/gltf/load.h"

#include <optional>
#include <set>

namespace sightline {

inline constexpr float default_margin = 5;  ///< percent

/// Frames of an animation, both included.
struct FrameRange {
    int first = 0, last = 0;
    double fps = 24;
    bool operator==(const FrameRange&) const = default;
};

/// Where to look from.
struct ViewOptions {
    /// A view (find_view), else the name or index of a camera; empty: the file's first, else "fit".
    std::string camera;
    /// Degrees by which the camera turns about +y through the scene's centre. A view that frames
    /// the scene frames it alike for all of them, unless `frame_each`.
    std::optional<float> orbit;
    /// Percent of the picture's width and height that a view leaves free on each side; unset:
    /// default_margin.
    std::optional<float> margin;
    bool ortho = false;                       ///< views that frame the scene are orthographic
    bool frame_each = false;                  ///< frame each picture for itself
    std::optional<FrameRange> frame_for;      ///< frame the scene for all these frames
    std::optional<Vec3d> look_from, look_at;  ///< world space; either: a free camera
    std::optional<Vec3> up;                   ///< of the free camera
    std::optional<float> f_stop;              ///< of a lens before 24 mm of film; unset: aperture
    std::optional<float> fov;                 ///< degrees, vertical; unset: the camera's, else 45
};

/// The environment light and the background.
struct LightOptions {
    std::string env;           ///< path, "studio" or "none"; empty: see choose_environment
    float env_rotation = 0;    ///< degrees about +y
    float env_brightness = 1;  ///< factor of its radiance
    float env_blur = 0;        ///< degrees: RenderSettings::background_blur
    std::optional<Background> background;  ///< unset: the scene's colour, else the environment
    Vec3 background_color{0, 0, 0};        ///< linear, for Background::color
};

inline constexpr float default_ground_mirror = 0.04f;

/// What stands below the scene.
struct GroundOptions {
    GroundKind kind = GroundKind::nothing;
    Vec3 color{0, 0, 0};                   ///< linear, of a matte one
    std::optional<double> height;          ///< world units; unset: the lowest point of the scene
    float mirror = default_ground_mirror;  ///< of a shadow ground: reflectance seen from above
};

/// How rays are intersected.
struct EngineOptions {
    std::string intersector = "auto";  ///< engine by name; "auto": as Needs decides
    std::string isa;                   ///< Embree's instruction set; empty: the best of the machine
};

/// What to write.
struct OutputOptions {
    std::vector<std::string> pictures;  ///< files; the ending chooses the format
    /// Files that the caller writes from the results; they must not be inputs either.
    std::vector<std::string> destinations;
    ToneMap tone_map = ToneMap::pbr_neutral;
    float exposure = 0;           ///< stops, of display pictures
    ColorViewOptions color_view;  ///< set: it replaces the tone map of display pictures
    Vec3 alpha_for{1, 1, 1};      ///< linear: what pictures with a shadow ground are laid over
    std::set<std::string> data;   ///< layers to write beside the first picture, see data_paths
    std::optional<double> depth_scale;  ///< world units of a step of depth; unset: by picture
    ExrOptions exr;                     ///< its threads are set by RunOptions::threads
    std::string command;                ///< the whole command line, for the pictures' metadata
    std::string stats, record_rays;     ///< files; empty: none
    bool keep_rays = false;             ///< fill RenderResult::rays even if no file takes them
    bool preview = false;               ///< fill AssetResult::preview
};

/// How to run. Nothing here changes a pixel.
struct RunOptions {
    unsigned threads = 0;             ///< 0: all
    bool resume = false;              ///< keep finished tiles, and use those that exist
    bool merge_parts = false;         ///< use kept tiles only; Error if one is missing
    std::optional<PicturePart> part;  ///< keep the tiles of this part and write no picture
    std::string tiles;                ///< folder for kept tiles; empty: beside the first picture
    bool show_progress = false;
    ProgressName name;  ///< of the progress
};

/// One asset from its file to its pictures. `settings` is completed by complete_settings.
struct RenderCommand {
    std::string asset;  ///< .gltf or .glb
    LoadOptions load;
    ViewOptions view;
    LightOptions light;
    GroundOptions ground;
    RenderSettings settings;
    EngineOptions engine;
    OutputOptions output;
    RunOptions run;
};

}  // namespace sightline
