#include "render/tile_renderer.h"

#include "render/sampling_rounds.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr int pixels_per_tile = tile_size * tile_size;
constexpr int samples_per_wave = 16;

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

// A value per pixel as the weighted mean of it and its neighbours in the tile, with the weights of
// a tent two pixels wide. The border of the tile does not depend on the crop, so the result does
// not either.
std::array<double, pixels_per_tile> blur(const std::array<double, pixels_per_tile>& values) {
    std::array<double, pixels_per_tile> result;
    for (int cy = 0; cy < tile_size; ++cy) {
        for (int cx = 0; cx < tile_size; ++cx) {
            double sum = 0, weights = 0;
            for (int y = std::max(cy - 1, 0); y <= std::min(cy + 1, tile_size - 1); ++y) {
                for (int x = std::max(cx - 1, 0); x <= std::min(cx + 1, tile_size - 1); ++x) {
                    const double weight = (2 - std::abs(x - cx)) * (2 - std::abs(y - cy));
                    sum += weight * values[static_cast<size_t>(y * tile_size + x)];
                    weights += weight;
                }
            }
            result[static_cast<size_t>(cy * tile_size + cx)] = sum / weights;
        }
    }
    return result;
}

// What is seen of a sample or a pixel's sums over white, where the ground's shadows fall on a
// transparent background.
template <class Seen>
Vec3 seen_of(const RenderContext& context, const Seen& seen) {
    return context.ground.exists() ? seen.radiance + seen.through : seen.radiance;
}

}  // namespace

void TileRenderer::render(int x0, int y0, Film& film, Counters& counters,
                          std::vector<RecordedRay>* recorded) {
    x0_ = x0;
    y0_ = y0;
    counters_ = &counters;
    recorded_ = recorded;
    pixels_.fill({});
    add_samples(all_pixels(), 0, samples_of_first_round(context_.settings, context_.needs));
    if (context_.settings.error > 0) refine();
    for (int y = 0; y < tile_size; ++y)
        for (int x = 0; x < tile_size; ++x)
            if (film.window.contains(x0 + x, y0 + y))
                context_.layers.resolve_pixel(film, x0 + x, y0 + y,
                                              pixels_[static_cast<size_t>(y * tile_size + x)]);
}

// Adds rounds to the first one. The number of a pixel's samples doubles from round to round: only
// powers of two keep the stratification of the sequence.
void TileRenderer::refine() {
    const RenderSettings& settings = context_.settings;
    int done = samples_of_first_round(settings, context_.needs);
    variances_.fill(0);
    std::vector<uint16_t> active =
        context_.needs.noise ? noisy_pixels(all_pixels(), done) : contrasting_pixels();
    while (done < settings.max_samples && !active.empty()) {
        const int next = std::min(std::max(2 * done, 4), settings.max_samples);
        add_samples(active, done, next);
        done = next;
        active = noisy_pixels(active, done);
    }
}

// Traces the samples from `begin` to before `end` of each active pixel.
void TileRenderer::add_samples(std::span<const uint16_t> active, int begin, int end) {
    for (int first = begin; first < end; first += samples_per_wave)
        add_wave(active, first, std::min(samples_per_wave, end - first));
}

void TileRenderer::add_wave(std::span<const uint16_t> active, int first, int count) {
    requests_.clear();
    for (const uint16_t i : active)
        for (int s = first; s < first + count; ++s) request_sample(i % tile_size, i / tile_size, s);
    const SampleBuffer& buffer = trace();
    const auto pixel_of = [&](size_t slot) -> Pixel& {
        return pixels_[active[slot / static_cast<size_t>(count)]];
    };
    for (size_t slot = 0; slot < buffer.samples.size(); ++slot) {
        add_sample(pixel_of(slot), buffer, slot);
        if (context_.settings.error > 0)
            pixel_of(slot).luminance.add(finite_luminance(seen_of(context_, buffer.samples[slot])));
    }
    const LayerNames& names = context_.layers.names;
    for (const CoverageSample& c : buffer.coverage)
        add_coverage(pixel_of(c.slot), names.object_ids[c.object], names.material_ids[c.material],
                     c.coverage);
}

// Those of the active pixels, which have `done` samples each, that need more. The variance of four
// numbers is itself uncertain, and a feature may fall between the samples of one pixel, so each
// pixel's is averaged with those of its neighbours; pixels that are finished keep theirs.
std::vector<uint16_t> TileRenderer::noisy_pixels(std::span<const uint16_t> active, int done) {
    if (done >= context_.settings.max_samples) return {};
    for (const uint16_t i : active) variances_[i] = pixels_[i].luminance.relative_variance();
    const auto shared = blur(variances_);
    std::vector<uint16_t> result;
    std::ranges::copy_if(active, std::back_inserter(result), [&](uint16_t i) {
        return needs_samples(shared[i], pixels_[i].rays, context_.settings.error);
    });
    return result;
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
                luminance_of[at] = display_luminance(
                    seen_of(context_, pixels_[static_cast<size_t>(y * tile_size + x)]));
            } else {
                ring.push_back(at);
                request_sample(x, y, 0);
            }
        }
    }
    const SampleBuffer& buffer = trace();
    for (size_t i = 0; i < ring.size(); ++i)
        luminance_of[ring[i]] = display_luminance(seen_of(context_, buffer.samples[i]));
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
