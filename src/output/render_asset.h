#pragma once
// The recipe: one asset from its file to its pictures.
#include "output/options.h"
#include "output/picture_check.h"

#include <stop_token>

namespace sightline {

/// Wall-clock seconds of each stage.
struct StageTimes {
    double load = 0, build = 0;
    double render = 0;  ///< with the compression of EXRs, which runs in parallel
    double write = 0;   ///< the rest of the outputs
    double total = 0;
};

/// A finished asset.
struct AssetResult {
    RenderResult picture;
    Needs needs;
    StageTimes seconds;
    std::vector<std::string> warnings;
    std::vector<FoundFault> faults;  ///< of the file, as in Scene
    uint64_t fault_count = 0;
    std::vector<SourceFile> inputs;  ///< every file that was read, the environment last
    std::string intersector;
    size_t scene_bytes = 0, intersector_bytes = 0;
    unsigned threads = 0;
    bool interrupted = false;
    /// Of a whole picture. If it shows nothing, the last warning says why.
    PictureContent content = PictureContent::something;
    Image preview;  ///< with OutputOptions::preview: the beauty layer as an 8-bit RGB picture
};

/// The backdrop of pictures in a built-in light, linear: #B0B0B0.
inline const Vec3 default_backdrop(0.4342f);

/// The command's settings, completed by its view, light and outputs and by the scene. The decisions
/// on camera and light are added to `report`, if there is one. Throws Error if the scene has no
/// such camera.
RenderSettings complete_settings(const RenderCommand& command, const Scene& scene,
                                 std::vector<Decision>* report = nullptr);

/// Loads, renders and writes. Throws Error.
AssetResult render_asset(const RenderCommand& command, std::stop_token stop = {});

}  // namespace sightline
