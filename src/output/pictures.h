#pragma once
#include "output/asset.h"

namespace sightline {

/// What an EXR tells of its making. No times: the same command writes the same bytes.
PictureInfo make_info(const AssetOptions& options, const RenderContext& context,
                      const std::string& engine);

/// The pictures that are asked for, as they come from the renderer.
class Pictures {
  public:
    Pictures(const AssetOptions& options, const RenderContext& context, const std::string& engine);

    /// The next rows. Throws Error.
    void add(const Film& band);

    /// All appear, one after the other. Throws Error.
    void finish(const RenderResult& result);

    /// Where AssetOptions::preview asks for it.
    Image preview() const { return preview_ ? preview_->picture() : Image{}; }

  private:
    PictureInfo info_;
    std::vector<std::unique_ptr<PictureWriter>> writers_;
    std::optional<DisplayGatherer> preview_;
};

/// What is added to the first output's path to name the folder of its finished tiles.
inline constexpr const char* checkpoint_ending = ".tiles";

/// A hash of all that the values of a tile depend on: the program, the contents of the files, the
/// options, the engine with its instruction set.
uint64_t tile_key(const AssetOptions& options, const RenderSettings& settings,
                  const std::vector<SourceFile>& inputs, const std::string& engine);

}  // namespace sightline
