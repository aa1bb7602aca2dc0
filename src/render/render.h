#pragma once
#include "render/bands.h"
#include "render/checkpoint.h"
#include "render/wave_tracer.h"

#include <stop_token>

namespace sightline {

/// What a render gives back beside its picture.
struct RenderResult {
    Counters counters;
    std::vector<RecordedRay> rays;  ///< where asked for; in tile order
    uint64_t tiles = 0, tiles_done = 0;
    uint64_t nonfinite_pixels = 0;
};

/// Options of the run, none of which changes the picture.
struct RenderRun {
    bool record_rays = false;
    bool show_progress = false;
    std::stop_token stop;  ///< asks for an early end: tiles that are begun are finished
    /// Or nullptr. Tiles that are there are not traced, the others are kept there; after an early
    /// end the sink has not got all rows.
    Checkpoint* checkpoint = nullptr;
};

/// Every `count`th tile of a picture, from the `index`th on.
struct PicturePart {
    unsigned index = 0, count = 1;
};

/// Renders the settings's window and hands its rows to `sink`, band by band from the top, so that
/// memory grows with the tiles in flight and not with the picture. Bit-identical for any number of
/// threads, and a crop equals that part of the whole: tiles lie on a grid fixed to the picture and
/// are always traced whole. What `sink` throws ends the render.
RenderResult render(const RenderContext& context, const BandSink& sink, const RenderRun& run = {});

/// Traces one part's tiles into run.checkpoint, as far as they are not there. When all parts are, a
/// render from that checkpoint traces nothing.
RenderResult render_part(const RenderContext& context, const PicturePart& part,
                         const RenderRun& run);

/// Tiles of the settings that are not in the checkpoint.
size_t missing_tiles(const RenderSettings& settings, const Checkpoint& checkpoint);

/// The needs that were paid for but that no ray of the render made use of.
std::vector<std::string> unused_needs(const Needs& needs, const Counters& counters);

}  // namespace sightline
