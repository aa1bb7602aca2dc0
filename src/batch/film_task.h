#pragma once
// Tasks that make a film of many pictures.
#include "batch/plan.h"
#include "batch/worker.h"
#include "output/render_asset.h"

#include <functional>
#include <string>
#include <vector>

namespace sightline {

/// The pictures that are the frames of a task's film, in order.
std::vector<PictureRequest> film_frames(const Task& task);

/// Renders a picture without writing it.
using RenderPicture = std::function<RenderedPicture(const RenderCommand&)>;

/// Renders the frames that no earlier attempt has kept, with `command` as what they have in common,
/// and makes the films at `files`, in the order of the task's outputs. Returns the result of the
/// first frame, with the sums of rays and seconds, and what is in any of the frames. Throws Error.
AssetResult make_film(const WorkerRequest& request, const ParseSettings& parse,
                      const RenderCommand& command, const std::vector<std::string>& files,
                      const RenderPicture& render);

}  // namespace sightline
