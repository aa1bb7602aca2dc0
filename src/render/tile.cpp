#include "render/tile.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr int pixels_per_tile = tile_size * tile_size;
constexpr int samples_per_wave = 16;
constexpr int first_estimate = 16;  // samples before a pixel's error is believed

// The compressed luminance in which the eye would compare: errors in highlights count less.
double display_luminance(const Vec3& c) {
    const double y = static_cast<double>(luminance(c));
    return y / (1 + y);
}

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

void accumulate(Pixel& pixel, const Sample& sample) {
    if (pixel.samples == 0) pixel.first = sample.first;
    pixel.radiance += sample.radiance;
    pixel.alpha += sample.alpha;
    pixel.rays += sample.rays;
    if (sample.first.valid) {
        pixel.normal += sample.first.normal;
        pixel.albedo += sample.first.albedo;
    }
    ++pixel.samples;
    const double value = display_luminance(sample.radiance);
    const double delta = value - pixel.mean;
    pixel.mean += delta / pixel.samples;
    pixel.squares += delta * (value - pixel.mean);
}

// Standard error of the pixel's mean relative to the mean, with a floor of 1 % grey.
bool is_converged(const Pixel& pixel, float error) {
    if (pixel.samples < first_estimate) return false;
    const double n = pixel.samples;
    const double standard_error = std::sqrt(pixel.squares / (n - 1) / n);
    return standard_error <= static_cast<double>(error) * std::max(pixel.mean, 0.01);
}

// A pixel goes on while it or a neighbour in the tile needs more, so that a feature which the
// first samples of one pixel missed is still found.
std::vector<uint16_t> unconverged(std::span<const Pixel> pixels, float error,
                                  std::span<const uint16_t> order) {
    std::array<bool, pixels_per_tile> open{};
    for (int i = 0; i < pixels_per_tile; ++i) {
        if (is_converged(pixels[static_cast<size_t>(i)], error)) continue;
        const int cx = i % tile_size, cy = i / tile_size;
        for (int y = std::max(cy - 1, 0); y <= std::min(cy + 1, tile_size - 1); ++y)
            for (int x = std::max(cx - 1, 0); x <= std::min(cx + 1, tile_size - 1); ++x)
                open[static_cast<size_t>(y * tile_size + x)] = true;
    }
    std::vector<uint16_t> result;
    std::copy_if(order.begin(), order.end(), std::back_inserter(result),
                 [&](uint16_t i) { return open[i]; });
    return result;
}

}  // namespace

void trace_tile(WaveTracer& tracer, const RenderJob& job, int x0, int y0, std::span<Pixel> pixels,
                Counters& counters, std::vector<RecordedRay>* recorded) {
    static const auto order = morton_order();
    const int budget = job.error > 0 ? job.max_samples : job.samples;
    std::vector<uint16_t> active(order.begin(), order.end());
    std::vector<WaveTracer::Request> requests;
    std::vector<Sample> samples;
    for (int done = 0; done < budget && !active.empty();) {
        const int batch = std::min(samples_per_wave, budget - done);
        requests.clear();
        for (const uint16_t i : active)
            for (int s = 0; s < batch; ++s)
                requests.push_back(
                    {x0 + i % tile_size, y0 + i / tile_size, static_cast<uint32_t>(done + s)});
        samples.resize(requests.size());
        tracer.trace(requests, samples, counters, recorded);
        for (size_t i = 0; i < samples.size(); ++i)
            accumulate(pixels[active[i / static_cast<size_t>(batch)]], samples[i]);
        done += batch;
        if (job.error > 0) active = unconverged(pixels, job.error, order);
    }
}

}  // namespace sightline
