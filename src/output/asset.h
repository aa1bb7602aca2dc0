#pragma once
// The recipe: one asset from its file to its pictures.
#include "output/write.h"
#include "render/render.h"
#include "scene/gltf/load.h"

#include <optional>
#include <stop_token>

namespace sightline {

/// What to make of one asset: the command line's options under the same names.
struct AssetOptions {
    std::string path;
    std::string command;               ///< the whole command line, for the pictures' metadata
    std::vector<std::string> outputs;  ///< the ending chooses the format
    LoadOptions load;
    int width = 512, height = 512;
    /// Name, index, "fit" or a side as in view_direction; empty: the file's first, else fitted.
    std::string camera;
    float orbit = 0;  ///< degrees by which the camera goes round the scene's centre about +y
    std::optional<Vec3> look_from, look_at, up;
    std::optional<float> fov;  ///< degrees, vertical
    float aperture = 0, focus = 0;
    std::string env;         ///< path, "studio" or "none"; empty: see chosen_environment
    float env_rotation = 0;  ///< degrees about +y
    std::string
        background;      ///< "env", "transparent" or "R,G,B" (linear); empty: the scene's, else env
    float exposure = 0;  ///< stops
    std::string tone_map = "pbr-neutral";
    std::string integrator = "whitted";
    int depth = 8, samples = 64, max_samples = 1024;
    float error = 0;
    uint32_t seed = 0;
    std::optional<PixelRect> crop;
    unsigned threads = 0;
    std::string isa;
    std::string intersector = "auto";  ///< an engine name, or auto: as Needs decides
    std::vector<std::string> aovs;     ///< empty: the default ones where an EXR is written
    bool half = false;                 ///< colours and normals in EXR as half floats
    ExrOptions exr;                    ///< its threads are chosen by `threads`
    std::string stats, record_rays;    ///< files
    bool resume = false;               ///< keep finished tiles, and go on from those that are there
    bool join = false;                 ///< resume where no tile is missing, else Error
    std::string tiles;                 ///< folder for them; empty: beside the first output
    std::optional<PicturePart> part;   ///< keep the tiles of this part and write no picture
    bool show_progress = false;
    bool keep_rays = false;  ///< RenderResult::rays, without a file
    bool preview = false;    ///< fill AssetResult::preview
    bool force_all = false;  ///< build and trace everything, whatever the scene needs
};

/// Wall-clock seconds of each stage.
struct StageTimes {
    double load = 0, build = 0;
    double render = 0;  ///< with the EXRs' compression, which goes on beside it
    double write = 0;   ///< what of the outputs is left to do then
    double total = 0;
};

/// A finished asset.
struct AssetResult {
    RenderResult picture;
    Needs needs;
    StageTimes seconds;
    std::vector<std::string> warnings;
    std::vector<SourceFile> inputs;  ///< every file that was read, the environment last
    std::string intersector;
    size_t scene_bytes = 0, intersector_bytes = 0;
    unsigned threads = 0;
    bool interrupted = false;
    Image preview;  ///< where asked for: the beauty layer as an 8-bit RGB display picture
};

/// The environment that lights the asset: the one asked for, else the studio where the file brings
/// neither a punctual light nor a background.
std::string chosen_environment(const AssetOptions& options, const Scene& scene);

/// The settings that the options describe for this scene. Throws Error where a camera is not there.
RenderSettings make_settings(const AssetOptions& options, const Scene& scene);

/// Loads, renders and writes. Throws Error; std::invalid_argument for an option's bad value.
AssetResult render_asset(const AssetOptions& options, std::stop_token stop = {});

/// The statistics of a finished asset as JSON text (fields as docs/statistics.md lists them).
std::string statistics_json(const AssetOptions& options, const AssetResult& result);

/// Three finite numbers "X,Y,Z"; std::invalid_argument otherwise.
Vec3 parse_vec3(const std::string& text);

/// Bytes of the scene's arrays and decoded images.
size_t scene_memory(const Scene& scene);

}  // namespace sightline
