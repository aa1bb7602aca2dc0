#include "render/render.h"

#include "core/parallel.h"
#include "core/progress.h"
#include "render/layers.h"
#include "render/sampler.h"
#include "render/tile.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <thread>
#include <tuple>

namespace sightline {
namespace {

/// Tiles of the fixed grid that touch the window, row by row.
std::vector<std::pair<int, int>> tiles_of(const PixelRect& window) {
    std::vector<std::pair<int, int>> tiles;
    for (int y = window.y0 / tile_size * tile_size; y < window.y1; y += tile_size)
        for (int x = window.x0 / tile_size * tile_size; x < window.x1; x += tile_size)
            tiles.emplace_back(x, y);
    return tiles;
}

void develop_tile(Film& film, int x0, int y0, std::span<const Pixel> pixels) {
    for (int y = y0; y < y0 + tile_size; ++y)
        for (int x = x0; x < x0 + tile_size; ++x)
            if (film.window.contains(x, y))
                develop(film, x, y, pixels[static_cast<size_t>((y - y0) * tile_size + x - x0)]);
}

/// Tracers to be used again from tile to tile, so that their arrays are allocated once a thread.
class TracerPool {
  public:
    explicit TracerPool(const Transport& transport) : transport_(transport) {}

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
    const Transport& transport_;
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

}  // namespace

std::vector<Vec3> absorption_of(const Scene& scene) {
    std::vector<Vec3> result;
    for (const Material& m : scene.materials) {
        const bool absorbs = m.thickness_factor > 0 && std::isfinite(m.attenuation_distance) &&
                             m.attenuation_distance > 0;
        const auto coefficient = [&](float color) {
            return absorbs ? -std::log(std::fmax(color, 1e-6f)) / m.attenuation_distance : 0.0f;
        };
        result.push_back({coefficient(m.attenuation_color.x), coefficient(m.attenuation_color.y),
                          coefficient(m.attenuation_color.z)});
    }
    return result;
}

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

Vec3 mean_radiance(const Environment& environment) {
    constexpr uint32_t n = 1024;
    Vec3 sum(0, 0, 0);
    for (uint32_t i = 0; i < n; ++i) {
        const Vec2 u = sample_2d(i, 0);
        const float y = 1 - 2 * u.y, r = std::sqrt(std::fmax(0.0f, 1 - y * y));
        sum += environment.radiance({r * std::cos(2 * pi * u.x), y, r * std::sin(2 * pi * u.x)});
    }
    return sum * (1.0f / n);
}

RenderResult render(const Transport& transport, const BandSink& sink, const RenderRun& run) {
    const RenderJob& job = transport.job;
    const auto tiles = tiles_of(window_of(job));
    RenderResult result;
    result.tiles = tiles.size();
    std::vector<std::vector<RecordedRay>> recorded(run.record_rays ? tiles.size() : 0);
    Progress progress("render", tiles.size(), run.show_progress);
    TracerPool tracers(transport);
    BandQueue bands(job, [&](const Film& band) {
        result.nonfinite_pixels += count_nonfinite(band);
        sink(band);
    });
    std::mutex merging;

    const auto trace = [&](size_t i) {
        const auto [x, y] = tiles[i];
        Film* band = bands.open(y);
        if (!band) return;
        if (!run.stop.stop_requested()) {
            std::array<Pixel, tile_size * tile_size> pixels;
            Counters counters;
            auto tracer = tracers.take();
            trace_tile(*tracer, transport, x, y, pixels, counters,
                       run.record_rays ? &recorded[i] : nullptr);
            tracers.give_back(std::move(tracer));
            develop_tile(*band, x, y, pixels);
            progress.advance();
            const std::lock_guard lock(merging);
            result.counters.add(counters);
            ++result.tiles_done;
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
    run_with_threads(job.threads, [&] { parallel_for(tiles.size(), trace_next); });
    for (const auto& rays : recorded)
        result.rays.insert(result.rays.end(), rays.begin(), rays.end());
    return result;
}

}  // namespace sightline
