#include "render/render.h"

#include "core/parallel.h"
#include "core/progress.h"
#include "render/tile_renderer.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>

namespace sightline {
namespace {

using Tiles = std::vector<std::pair<int, int>>;  // by their first pixels

/// Tiles of the fixed grid that overlap the window, row by row.
Tiles tiles_of(const PixelRect& window) {
    Tiles tiles;
    for (int y = window.y0 / tile_size * tile_size; y < window.y1; y += tile_size)
        for (int x = window.x0 / tile_size * tile_size; x < window.x1; x += tile_size)
            tiles.emplace_back(x, y);
    return tiles;
}

// Counts the pixels of a band that are not finite, and those that are not black.
void count_pixels(const Film& film, RenderResult& result) {
    const size_t pixels = film.channels[0].values.size();
    for (size_t i = 0; i < pixels; ++i) {
        bool finite = true, lit = false;
        for (size_t c = 0; c < 4; ++c) {
            const float value = film.channels[c].values[i];
            finite = finite && std::isfinite(value);
            lit = lit || (c < 3 && value != 0);
        }
        result.nonfinite_pixels += !finite;
        result.lit_pixels += lit;
    }
}

// The state that the threads of a render share. Thread-safe.
class RenderState {
  public:
    RenderState(const RenderContext& context, const RenderRun& run, Tiles tiles)
        : context_(context),
          run_(run),
          tiles_(std::move(tiles)),
          recorded_(run.record_rays ? tiles_.size() : 0),
          progress_("render", run.name, tiles_.size(), run.show_progress) {}

    const Tiles& tiles() const { return tiles_; }

    Film blank_tile(size_t i) const {
        const auto [x, y] = tiles_[i];
        return blank_film(context_.layers.layout, {x, y, x + tile_size, y + tile_size});
    }

    // Writes tile i into the film; false and unchanged after a request to stop.
    bool render_tile(size_t i, Film& film) {
        Counters counters;
        if (!render_tile(i, film, counters)) return false;
        add_done(counters);
        return true;
    }

    // The same, from or into the run's checkpoint; `tile` is a film over the tile alone.
    bool restore_or_render_tile(size_t i, Film& tile) {
        Counters counters;
        if (!run_.checkpoint->restore(tile, counters)) {
            if (!render_tile(i, tile, counters)) return false;
            run_.checkpoint->keep(tile, counters);
        }
        add_done(counters);
        return true;
    }

    RenderResult take_result() {
        result_.tiles = tiles_.size();
        for (const auto& rays : recorded_)
            result_.rays.insert(result_.rays.end(), rays.begin(), rays.end());
        return std::move(result_);
    }

  private:
    bool render_tile(size_t i, Film& film, Counters& counters) {
        if (run_.stop.stop_requested()) return false;
        const auto [x, y] = tiles_[i];
        std::unique_ptr<TileRenderer> renderer = take_renderer();
        const auto begin = std::chrono::steady_clock::now();
        renderer->render(x, y, film, counters, run_.record_rays ? &recorded_[i] : nullptr);
        const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
        const std::lock_guard lock(mutex_);
        result_.thread_seconds += time.count();
        idle_.push_back(std::move(renderer));
        return true;
    }

    std::unique_ptr<TileRenderer> take_renderer() {
        const std::lock_guard lock(mutex_);
        if (idle_.empty()) return std::make_unique<TileRenderer>(context_);
        std::unique_ptr<TileRenderer> renderer = std::move(idle_.back());
        idle_.pop_back();
        return renderer;
    }

    void add_done(const Counters& counters) {
        progress_.advance();
        const std::lock_guard lock(mutex_);
        result_.counters.add(counters);
        ++result_.tiles_done;
    }

    const RenderContext& context_;
    const RenderRun& run_;
    const Tiles tiles_;
    std::vector<std::vector<RecordedRay>> recorded_;  // by tile
    Progress progress_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<TileRenderer>> idle_;
    RenderResult result_;
};

}  // namespace

RenderResult render(const RenderContext& context, const BandSink& sink, const RenderRun& run) {
    const RenderSettings& settings = context.settings;
    RenderState state(context, run, tiles_of(window_of(settings)));
    RenderResult pixels;
    BandQueue bands(settings, run.threads, context.layers.layout, [&](const Film& band) {
        count_pixels(band, pixels);
        sink(band);
    });
    const auto render_tile = [&](size_t i) {
        const int y = state.tiles()[i].second;
        Film* band = bands.open(y);
        if (!band) return;
        if (run.checkpoint) {
            Film tile = state.blank_tile(i);
            if (!state.restore_or_render_tile(i, tile)) return bands.abandon();
            copy_pixels(*band, tile, intersection(band->window, tile.window));
        } else {
            state.render_tile(i, *band);
        }
        bands.close_tile(y);
    };
    // In order, so that few bands are unfinished at a time.
    std::atomic<size_t> next{0};
    const auto render_next = [&](size_t) {
        try {
            render_tile(next++);
        } catch (...) {
            bands.abandon();
            throw;
        }
    };
    run_with_threads(run.threads, [&] { parallel_for(state.tiles().size(), render_next); });
    RenderResult result = state.take_result();
    result.nonfinite_pixels = pixels.nonfinite_pixels;
    result.lit_pixels = pixels.lit_pixels;
    return result;
}

RenderResult render_part(const RenderContext& context, const PicturePart& part,
                         const RenderRun& run) {
    const RenderSettings& settings = context.settings;
    const Tiles all = tiles_of(window_of(settings));
    Tiles own;
    for (size_t i = part.index; i < all.size(); i += part.count) own.push_back(all[i]);
    RenderState state(context, run, std::move(own));
    const auto render_tile = [&](size_t i) {
        Film tile = state.blank_tile(i);
        state.restore_or_render_tile(i, tile);
    };
    run_with_threads(run.threads, [&] { parallel_for(state.tiles().size(), render_tile); });
    return state.take_result();
}

size_t missing_tiles(const RenderSettings& settings, const Checkpoint& checkpoint) {
    const Tiles tiles = tiles_of(window_of(settings));
    return static_cast<size_t>(std::ranges::count_if(
        tiles, [&](const auto& tile) { return !checkpoint.has(tile.first, tile.second); }));
}

}  // namespace sightline
