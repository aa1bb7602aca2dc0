#pragma once
// The recipe: one asset from its file to its pictures.
#include "output/options.h"
#include "output/rendered_picture.h"

#include <memory>
#include <stop_token>

namespace sightline {

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

    /// The same without writing. Recorded rays, and pictures whose tiles are kept, are written.
    RenderedPicture render_unwritten(const RenderCommand& command, std::stop_token stop = {});

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Loads, renders and writes. Throws Error.
AssetResult render_asset(const RenderCommand& command, std::stop_token stop = {});

}  // namespace sightline
