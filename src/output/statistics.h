#pragma once
#include "output/render_asset.h"

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <utility>

namespace sightline {

/// The seconds of the stages in which an asset becomes a picture, in their order. They do not
/// overlap; the total is a little more.
std::array<std::pair<const char*, double>, 9> stages_of(const StageTimes& seconds);

/// The statistics of a finished asset as JSON text (fields as docs/statistics.md lists them).
std::string statistics_json(const RenderCommand& command, const AssetResult& result);

/// Faults as an array of objects with key, place and text.
nlohmann::json faults_json(std::span<const FoundFault> faults);

/// Bytes of the scene's arrays and decoded images.
size_t scene_memory(const Scene& scene);

}  // namespace sightline
