#pragma once
#include "output/render_asset.h"

namespace sightline {

/// The statistics of a finished asset as JSON text (fields as docs/statistics.md lists them).
std::string statistics_json(const RenderCommand& command, const AssetResult& result);

/// Bytes of the scene's arrays and decoded images.
size_t scene_memory(const Scene& scene);

}  // namespace sightline
