#pragma once
#include "output/render_asset.h"

namespace sightline {

/// Renders and writes the command's pictures and recorded rays. Fills result.picture, preview and
/// seconds.write. With RunOptions' resume, merge_parts or part it keeps finished
/// tiles in a folder; a part writes nothing else. Throws Error.
void render_pictures(const RenderCommand& command, const RenderContext& context, RenderRun run,
                     AssetResult& result);

}  // namespace sightline
