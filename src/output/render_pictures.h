#pragma once
#include "output/output_set.h"
#include "output/render_asset.h"

#include <chrono>

namespace sightline {

/// Of the steady clock.
inline double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Renders the command's pictures and returns them for finish_pictures, which writes them. With
/// RunOptions' resume, merge_parts or part it keeps finished tiles in a folder; a part writes
/// nothing else. Pictures with kept tiles or recorded rays are finished here, and none is returned.
/// Fills result.picture. Throws Error.
std::unique_ptr<OutputSet> render_pictures(const RenderCommand& command,
                                           const RenderContext& context, RenderRun run,
                                           AssetResult& result);

/// Encodes and writes what is rendered. Fills result.preview and data_scales and adds to
/// seconds.write. Throws Error.
void finish_pictures(OutputSet& outputs, AssetResult& result);

}  // namespace sightline
