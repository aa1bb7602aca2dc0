#include "render/render.h"

#include "core/parallel.h"
#include "core/progress.h"
#include "render/layers.h"
#include "render/tile.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <tuple>

namespace sightline {
namespace {

using Tiles = std::vector<std::pair<int, int>>;  // by their first pixels

/// Tiles of the fixed grid that touch the window, row by row.
Tiles tiles_of(const PixelRect& window) {
    Tiles tiles;
    for (int y = window.y0 / tile_size * tile_size; y < window.y1; y += tile_size)
        for (int x = window.x0 / tile_size * tile_size; x < window.x1; x += tile_size)
            tiles.emplace_back(x, y);
    return tiles;
}

void develop_tile(Film& film, const LayerNames& names, int x0, int y0,
                  std::span<const Pixel> pixels) {
    for (int y = y0; y < y0 + tile_size; ++y)
        for (int x = x0; x < x0 + tile_size; ++x)
            if (film.window.contains(x, y))
                develop(film, names, x, y,
                        pixels[static_cast<size_t>((y - y0) * tile_size + x - x0)]);
}

/// Tracers to be used again from tile to tile, so that their arrays are allocated once a thread.
class TracerPool {
  public:
    explicit TracerPool(const RenderContext& context) : transport_(context) {}

    std::unique_ptr<WaveTracer> take() {
        const std::lock_guard lock(mutex_);
        if (idle_.empty()) return std::make_unique<WaveTracer>(transport_);
        auto tracer = std::move(idle_.back());
        idle_.pop_back();
        return tracer;
    }

    void give_back(std::unique_ptr<WaveTracer> tracer) {
        const std::lock_guard lock(mutex_);
        idle_.push_back(std::move(tracer));
    }

  private:
    const RenderContext& transport_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<WaveTracer>> idle_;
};

uint64_t count_nonfinite(const Film& film) {
    uint64_t count = 0;
    const size_t pixels = film.channels[0].values.size();
    for (size_t i = 0; i < pixels; ++i) {
        bool finite = true;
        for (size_t c = 0; c < 4; ++c) finite = finite && std::isfinite(film.channels[c].values[i]);
        count += !finite;
    }
    return count;
}

// What all threads of a render share while tiles are traced.
class TileTracer {
  public:
    TileTracer(const RenderContext& context, const RenderRun& run, Tiles tiles)
        : transport_(context),
          run_(run),
          tiles_(std::move(tiles)),
          recorded_(run.record_rays ? tiles_.size() : 0),
          progress_("render", tiles_.size(), run.show_progress),
          tracers_(context) {}

    const Tiles& tiles() const { return tiles_; }

    // Leaves the film as it is where the render is to end.
    bool trace(size_t i, Film& film) {
        Counters counters;
        if (!trace(i, film, counters)) return false;
        done(counters);
        return true;
    }

    // The same with the run's checkpoint; `tile` is a film over the tile alone.
    bool restore_or_trace(size_t i, Film& tile) {
        Counters counters;
        if (!run_.checkpoint->restore(tile, counters)) {
            if (!trace(i, tile, counters)) return false;
            run_.checkpoint->keep(tile, counters);
        }
        done(counters);
        return true;
    }

    RenderResult result() {
        result_.tiles = tiles_.size();
        for (const auto& rays : recorded_)
            result_.rays.insert(result_.rays.end(), rays.begin(), rays.end());
        return std::move(result_);
    }

  private:
    bool trace(size_t i, Film& film, Counters& counters) {
        if (run_.stop.stop_requested()) return false;
        const auto [x, y] = tiles_[i];
        std::array<Pixel, tile_size * tile_size> pixels;
        auto tracer = tracers_.take();
        trace_tile(*tracer, transport_, x, y, pixels, counters,
                   run_.record_rays ? &recorded_[i] : nullptr);
        tracers_.give_back(std::move(tracer));
        develop_tile(film, transport_.names, x, y, pixels);
        return true;
    }

    void done(const Counters& counters) {
        progress_.advance();
        const std::lock_guard lock(merging_);
        result_.counters.add(counters);
        ++result_.tiles_done;
    }

    const RenderContext& transport_;
    const RenderRun& run_;
    Tiles tiles_;
    std::vector<std::vector<RecordedRay>> recorded_;
    Progress progress_;
    TracerPool tracers_;
    std::mutex merging_;
    RenderResult result_;
};

}  // namespace

std::vector<std::string> unused_needs(const Needs& needs, const Counters& c) {
    const uint64_t secondary = c.rays[static_cast<size_t>(RayKind::reflection)] +
                               c.rays[static_cast<size_t>(RayKind::refraction)];
    const std::tuple<const char*, bool, uint64_t> paid[] = {
        {"pass_through", needs.pass_through, c.uncovered_hits},
        {"coloured_shadows", needs.coloured_shadows, c.coloured_shadow_rays},
        {"volumes", needs.volumes, c.absorbed_rays},
        {"area_lights", needs.area_lights, c.area_light_samples},
        {"environment_light", needs.environment_light, c.environment_samples},
        {"secondary_rays", needs.secondary_rays, secondary},
    };
    std::vector<std::string> unused;
    for (const auto& [name, on, used] : paid)
        if (on && used == 0) unused.push_back(name);
    return unused;
}

RenderResult render(const RenderContext& context, const BandSink& sink, const RenderRun& run) {
    const RenderSettings& settings = context.settings;
    TileTracer tracer(context, run, tiles_of(window_of(settings)));
    uint64_t nonfinite = 0;
    const Film layout = layout_of(settings, context.names);
    BandQueue bands(settings, layout, [&](const Film& band) {
        nonfinite += count_nonfinite(band);
        sink(band);
    });
    const auto trace = [&](size_t i) {
        const auto [x, y] = tracer.tiles()[i];
        Film* band = bands.open(y);
        if (!band) return;
        if (run.checkpoint) {
            Film tile = blank_film(layout, {x, y, x + tile_size, y + tile_size});
            if (!tracer.restore_or_trace(i, tile)) return bands.abandon();
            copy_pixels(*band, tile, intersection(band->window, tile.window));
        } else {
            tracer.trace(i, *band);
        }
        bands.close_tile(y);
    };
    // In order, so that few bands are unfinished at a time.
    std::atomic<size_t> next{0};
    const auto trace_next = [&](size_t) {
        try {
            trace(next++);
        } catch (...) {
            bands.abandon();
            throw;
        }
    };
    run_with_threads(settings.threads, [&] { parallel_for(tracer.tiles().size(), trace_next); });
    RenderResult result = tracer.result();
    result.nonfinite_pixels = nonfinite;
    return result;
}

RenderResult render_part(const RenderContext& context, const PicturePart& part,
                         const RenderRun& run) {
    const RenderSettings& settings = context.settings;
    const auto all = tiles_of(window_of(settings));
    Tiles own;
    for (size_t i = part.index; i < all.size(); i += part.count) own.push_back(all[i]);
    TileTracer tracer(context, run, std::move(own));
    const Film layout = layout_of(settings, context.names);
    const auto trace = [&](size_t i) {
        const auto [x, y] = tracer.tiles()[i];
        Film tile = blank_film(layout, {x, y, x + tile_size, y + tile_size});
        tracer.restore_or_trace(i, tile);
    };
    run_with_threads(settings.threads, [&] { parallel_for(tracer.tiles().size(), trace); });
    return tracer.result();
}

size_t missing_tiles(const RenderSettings& settings, const Checkpoint& checkpoint) {
    const auto tiles = tiles_of(window_of(settings));
    return static_cast<size_t>(std::ranges::count_if(
        tiles, [&](const auto& tile) { return !checkpoint.has(tile.first, tile.second); }));
}

}  // namespace sightline
