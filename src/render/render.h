#pragma once
#include "core/progress.h"
#include "render/bands.h"
#include "render/checkpoint.h"
#include "render/render_context.h"
#include "render/samples.h"

#include <stop_token>

namespace sightline {

/// What a render returns beside its picture.
struct RenderResult {
    Counters counters;
    std::vector<RecordedRay> rays;  ///< with RenderRun::record_rays; in tile order
    uint64_t tiles = 0, tiles_done = 0;
    uint64_t nonfinite_pixels = 0;
    uint64_t lit_pixels = 0;    ///< with a colour other than black
    double thread_seconds = 0;  ///< sum over all threads of the time that tiles took
};

/// Options of a render that do not change the picture.
struct RenderRun {
    unsigned threads = 0;  ///< 0: all
    bool record_rays = false;
    bool show_progress = false;
    ProgressName name{};     ///< of the progress
    std::stop_token stop{};  ///< requests an early end: tiles in progress are finished
    /// Or nullptr. Tiles in it are not rendered again, and new ones are added to it. After an early
    /// end the sink has not received all rows.
    Checkpoint* checkpoint = nullptr;
};

/// Every `count`th tile of a picture, starting with tile `index`.
struct PicturePart {
    unsigned index = 0, count = 1;
};

/// Renders the settings' window and hands its rows to `sink`, band by band from the top, so that
/// memory grows with the tiles in progress and not with the picture. Bit-identical for any number
/// of threads. A crop equals that part of the whole picture: tiles lie on a grid fixed to the
/// picture and are always rendered whole. An exception from `sink` ends the render.
RenderResult render(const RenderContext& context, const BandSink& sink, const RenderRun& run = {});

/// Renders those tiles of one part that run.checkpoint lacks into it. A render from a checkpoint
/// with all parts traces no ray.
RenderResult render_part(const RenderContext& context, const PicturePart& part,
                         const RenderRun& run);

/// Number of the picture's tiles that the checkpoint lacks.
size_t missing_tiles(const RenderSettings& settings, const Checkpoint& checkpoint);

}  // namespace sightline
