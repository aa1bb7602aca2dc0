#include "render/tile_renderer.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr int pixels_per_tile = tile_size * tile_size;
constexpr int samples_per_wave = 16;
constexpr int samples_per_edge_round = 4;  // of a picture without noise

// Pixels in Morton order, so that 16 neighbours in a wave are a 4×4 block.
std::array<uint16_t, pixels_per_tile> morton_order() {
    std::array<uint16_t, pixels_per_tile> order{};
    for (unsigned i = 0; i < order.size(); ++i) {
        unsigned x = 0, y = 0;
        for (unsigned bit = 0; bit < 4; ++bit) {
            x |= (i >> (2 * bit) & 1) << bit;
            y |= (i >> (2 * bit + 1) & 1) << bit;
        }
        order[i] = static_cast<uint16_t>(y * tile_size + x);
    }
    return order;
}

std::span<const uint16_t> all_pixels() {
    static const auto order = morton_order();
    return order;
}

// The active pixels that need more samples: a pixel does while it or a neighbour in the tile has
// not converged, so that a feature which the first samples of one pixel missed is still found.
std::vector<uint16_t> unconverged_pixels(std::span<const Pixel> pixels, float error,
                                         std::span<const uint16_t> active) {
    std::array<bool, pixels_per_tile> open{};
    for (const uint16_t i : active) {
        if (is_converged(pixels[i], error)) continue;
        const int cx = i % tile_size, cy = i / tile_size;
        for (int y = std::max(cy - 1, 0); y <= std::min(cy + 1, tile_size - 1); ++y)
            for (int x = std::max(cx - 1, 0); x <= std::min(cx + 1, tile_size - 1); ++x)
                open[static_cast<size_t>(y * tile_size + x)] = true;
    }
    std::vector<uint16_t> result;
    std::ranges::copy_if(active, std::back_inserter(result), [&](uint16_t i) { return open[i]; });
    return result;
}

}  // namespace

void TileRenderer::render(int x0, int y0, Film& film, Counters& counters,
                          std::vector<RecordedRay>* recorded) {
    x0_ = x0;
    y0_ = y0;
    counters_ = &counters;
    recorded_ = recorded;
    pixels_.fill({});
    sample_tile();
    for (int y = 0; y < tile_size; ++y)
        for (int x = 0; x < tile_size; ++x)
            if (film.window.contains(x0 + x, y0 + y))
                context_.layers.resolve_pixel(film, x0 + x, y0 + y,
                                              pixels_[static_cast<size_t>(y * tile_size + x)]);
}

void TileRenderer::sample_tile() {
    const RenderSettings& settings = context_.settings;
    const bool adaptive = settings.error > 0;
    const bool by_contrast = adaptive && !context_.needs.noise;
    const int budget = adaptive ? settings.max_samples : settings.samples;
    const int round = by_contrast ? samples_per_edge_round : samples_per_wave;
    std::vector<uint16_t> active(all_pixels().begin(), all_pixels().end());
    int done = 0;
    if (by_contrast) {
        add_samples(active, 0, 1);
        active = contrasting_pixels();
        done = 1;
    }
    while (done < budget && !active.empty()) {
        const int count = std::min(round, budget - done);
        add_samples(active, done, count);
        done += count;
        if (adaptive) active = unconverged_pixels(pixels_, settings.error, active);
    }
}

// Traces the samples first … first + count − 1 of each active pixel.
void TileRenderer::add_samples(std::span<const uint16_t> active, int first, int count) {
    requests_.clear();
    for (const uint16_t i : active)
        for (int s = first; s < first + count; ++s) request_sample(i % tile_size, i / tile_size, s);
    const SampleBuffer& buffer = trace();
    const auto pixel_of = [&](size_t slot) -> Pixel& {
        return pixels_[active[slot / static_cast<size_t>(count)]];
    };
    for (size_t slot = 0; slot < buffer.samples.size(); ++slot) {
        add_sample(pixel_of(slot), buffer, slot);
        if (context_.settings.error > 0) add_to_estimate(pixel_of(slot), buffer.samples[slot]);
    }
    const LayerNames& names = context_.layers.names;
    for (const CoverageSample& c : buffer.coverage)
        add_coverage(pixel_of(c.slot), names.object_ids[c.object], names.material_ids[c.material],
                     c.coverage);
}

// Pixels of the tile whose first sample differs by more than the error from that of a neighbour.
// Also samples the ring of pixels around the tile, so that both sides see an edge along its border.
std::vector<uint16_t> TileRenderer::contrasting_pixels() {
    constexpr int size = tile_size + 2;  // of the tile and the ring
    std::array<double, size * size> luminance_of;
    std::vector<size_t> ring;
    requests_.clear();
    for (int y = -1; y <= tile_size; ++y) {
        for (int x = -1; x <= tile_size; ++x) {
            const auto at = static_cast<size_t>((y + 1) * size + x + 1);
            if (x >= 0 && y >= 0 && x < tile_size && y < tile_size) {
                luminance_of[at] = pixels_[static_cast<size_t>(y * tile_size + x)].mean;
            } else {
                ring.push_back(at);
                request_sample(x, y, 0);
            }
        }
    }
    const SampleBuffer& buffer = trace();
    for (size_t i = 0; i < ring.size(); ++i)
        luminance_of[ring[i]] = display_luminance(buffer.samples[i].radiance);
    std::vector<uint16_t> result;
    for (const uint16_t i : all_pixels()) {
        const int centre = (i / tile_size + 1) * size + i % tile_size + 1;
        double largest = 0;
        for (const int step : {-size - 1, -size, -size + 1, -1, 1, size - 1, size, size + 1})
            largest =
                std::max(largest, std::fabs(luminance_of[static_cast<size_t>(centre)] -
                                            luminance_of[static_cast<size_t>(centre + step)]));
        if (largest > static_cast<double>(context_.settings.error)) result.push_back(i);
    }
    return result;
}

}  // namespace sightline
