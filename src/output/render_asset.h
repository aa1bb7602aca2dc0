#pragma once
// The recipe: one asset from its file to its pictures.
#include "output/data_layers.h"
#include "output/options.h"
#include "output/picture_check.h"
#include "output/poses.h"

#include <memory>
#include <stop_token>

namespace sightline {

/// Wall-clock seconds of each stage. What pictures share costs the first of them alone.
struct StageTimes {
    double open = 0;     ///< reading the glTF file
    double parse = 0;    ///< its JSON and geometry, and its buffers
    double pose = 0;     ///< taking the scene to another time than that of the picture before
    double decode = 0;   ///< images, and the environment where that takes longer
    double build = 0;    ///< the acceleration structure
    double prepare = 0;  ///< pyramids of textures, emitters, faces that let light through
    double trace = 0;    ///< rays through the structure: the threads' share of `render`
    double shade = 0;    ///< the rest of `render`
    double render = 0;   ///< with the compression of EXRs, which runs in parallel
    double write = 0;    ///< the rest of the outputs
    double total = 0;

    double load() const { return open + parse + pose + decode; }

    void add(const StageTimes& more);
};

/// Bytes that the stages have read and made.
struct StageBytes {
    size_t files = 0;         ///< read: glTF, buffers, images; 0 if they were in memory
    size_t images = 0;        ///< of the decoded levels
    size_t whole_images = 0;  ///< the same if level 0 of each were kept
    size_t pyramids = 0;      ///< the levels made of them
};

/// A finished asset.
struct AssetResult {
    RenderResult picture;
    Needs needs;
    StageTimes seconds;
    StageBytes bytes;
    uint64_t finer_lookups = 0;  ///< in textures: of levels that were not kept
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
    CameraPose pose;
    std::map<std::string, DataScale> data_scales;  ///< by layer of OutputOptions::data
    Image preview;  ///< with OutputOptions::preview: the beauty layer as an 8-bit RGB picture
};

/// The backdrop of pictures in a built-in light, linear: #B0B0B0.
inline const Vec3 default_backdrop(0.4342f);

/// Throws Error if an output could not be written, OutputIsInput if it is the asset or environment.
void check_outputs(const RenderCommand& command);

/// The command's settings, completed by its view, light and outputs and by the scene. The decisions
/// on camera and light are added to `report`, if there is one. Throws Error if the scene has no
/// such camera.
RenderSettings complete_settings(const RenderCommand& command, const Scene& scene,
                                 std::vector<Decision>* report = nullptr);

/// An asset in memory, from which its pictures are rendered: they share the file, textures, the
/// environment, what does not move between their times, and between pictures of one time the
/// backdrop made of the environment and the acceleration structure. Each has the same bits as if it
/// were rendered alone.
class Asset {
  public:
    enum class Pictures { one, several };  ///< one: what only others need is freed early

    /// Reads the command's file and environment. Throws Error.
    explicit Asset(const RenderCommand& command, Pictures pictures = Pictures::several);
    ~Asset();

    /// Whether render() takes the command: has_loaded(), and no file that was read has changed
    /// since.
    bool serves(const RenderCommand& command) const;

    /// Whether the command has the same file, options of loading and environment. With
    /// Pictures::several, the times of animated pictures may differ. False once a pose has failed.
    bool has_loaded(const RenderCommand& command) const;

    /// Every file that was read, the environment last.
    const std::vector<SourceFile>& inputs() const;

    /// At the time of the last picture.
    const Scene& scene() const;

    /// Throws Error if the command asks for a camera that the file does not have.
    void check_camera(const RenderCommand& command) const;

    /// Renders and writes what has_loaded() accepts. Throws Error.
    AssetResult render(const RenderCommand& command, std::stop_token stop = {});

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Loads, renders and writes. Throws Error.
AssetResult render_asset(const RenderCommand& command, std::stop_token stop = {});

}  // namespace sightline
