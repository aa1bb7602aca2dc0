#include "render/tile.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr int pixels_per_tile = tile_size * tile_size;
constexpr int samples_per_wave = 16;
constexpr int samples_per_edge_round = 4;  // of a picture without noise
constexpr uint32_t first_estimate = 4;     // samples before a pixel's error is believed

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
}

// Welford's running sums, for the pixel's error.
void estimate(Pixel& pixel, const Sample& sample) {
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

// Of the `active` pixels those that go on: a pixel does while it or a neighbour in the tile needs
// more, so that a feature which the first samples of one pixel missed is still found.
std::vector<uint16_t> unconverged(std::span<const Pixel> pixels, float error,
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
    std::copy_if(active.begin(), active.end(), std::back_inserter(result),
                 [&](uint16_t i) { return open[i]; });
    return result;
}

// Display luminance of one sample through the centre of each pixel of the tile and of the ring
// around it, so that an edge along the tile's border is seen from both sides.
constexpr int ring_size = tile_size + 2;
using Ring = std::array<double, ring_size * ring_size>;

// Pixels of the tile that differ from a neighbour by more than `error`.
std::vector<uint16_t> contrasting(const Ring& ring, float error, std::span<const uint16_t> order) {
    std::vector<uint16_t> result;
    for (const uint16_t i : order) {
        const int centre = (i / tile_size + 1) * ring_size + i % tile_size + 1;
        double largest = 0;
        for (const int neighbour : {-ring_size - 1, -ring_size, -ring_size + 1, -1, 1,
                                    ring_size - 1, ring_size, ring_size + 1})
            largest = std::max(largest, std::fabs(ring[static_cast<size_t>(centre)] -
                                                  ring[static_cast<size_t>(centre + neighbour)]));
        if (largest > static_cast<double>(error)) result.push_back(i);
    }
    return result;
}

}  // namespace

// One tile's sampling: the requests of a round and where their samples go.
class TileSampler {
  public:
    /// `adaptive`: keep the sums of which pixels' errors are estimated.
    TileSampler(WaveTracer& tracer, const LayerNames& names, bool adaptive, int x0, int y0,
                std::span<Pixel> pixels, Counters& counters, std::vector<RecordedRay>* recorded)
        : tracer_(tracer),
          names_(names),
          adaptive_(adaptive),
          x0_(x0),
          y0_(y0),
          pixels_(pixels),
          counters_(counters),
          recorded_(recorded) {}

    // Samples first … first + count − 1 of each of these pixels of the tile.
    void sample(std::span<const uint16_t> active, int first, int count) {
        requests_.clear();
        for (const uint16_t i : active)
            for (int s = first; s < first + count; ++s) request(i % tile_size, i / tile_size, s);
        trace();
        for (size_t i = 0; i < samples_.size(); ++i) {
            Pixel& pixel = pixels_[active[i / static_cast<size_t>(count)]];
            accumulate(pixel, samples_[i]);
            if (adaptive_) estimate(pixel, samples_[i]);
        }
        const auto pixel_of = [&](size_t slot) -> Pixel& {
            return pixels_[active[slot / static_cast<size_t>(count)]];
        };
        gather_lights(pixel_of);
        gather_coverage(pixel_of);
    }

    // The first sample of the ring of pixels around the tile, and the tile's own, for contrast.
    Ring ring() {
        requests_.clear();
        std::vector<size_t> places;
        Ring result;
        for (int y = -1; y <= tile_size; ++y) {
            for (int x = -1; x <= tile_size; ++x) {
                const auto place = static_cast<size_t>((y + 1) * ring_size + x + 1);
                if (x >= 0 && y >= 0 && x < tile_size && y < tile_size) {
                    result[place] = pixels_[static_cast<size_t>(y * tile_size + x)].mean;
                } else {
                    places.push_back(place);
                    request(x, y, 0);
                }
            }
        }
        trace();
        for (size_t i = 0; i < places.size(); ++i)
            result[places[i]] = display_luminance(samples_[i].radiance);
        return result;
    }

  private:
    template <class PixelOf>
    void gather_lights(const PixelOf& pixel_of) {
        const auto light = tracer_.light_by_group();
        if (light.empty()) return;
        const size_t groups = light.size() / samples_.size();
        for (size_t i = 0; i < samples_.size(); ++i) {
            std::vector<Vec3>& sums = pixel_of(i).lights;
            sums.resize(groups, Vec3(0, 0, 0));
            for (size_t g = 0; g < groups; ++g) sums[g] += light[i * groups + g];
        }
    }

    template <class PixelOf>
    void gather_coverage(const PixelOf& pixel_of) {
        const auto add = [](std::vector<Coverage>& coverage, uint32_t id, float share) {
            const auto found = std::ranges::find(coverage, id, &Coverage::first);
            if (found == coverage.end()) {
                coverage.push_back({id, share});
            } else {
                found->second += share;
            }
        };
        for (const Seen& seen : tracer_.seen()) {
            Pixel& pixel = pixel_of(seen.slot);
            add(pixel.objects, names_.object_ids[seen.object], seen.coverage);
            add(pixel.materials, names_.material_ids[seen.material], seen.coverage);
        }
    }

    void request(int x, int y, int sample) {
        requests_.push_back({x0_ + x, y0_ + y, static_cast<uint32_t>(sample)});
    }

    void trace() {
        samples_.resize(requests_.size());
        tracer_.trace(requests_, samples_, counters_, recorded_);
    }

    WaveTracer& tracer_;
    const LayerNames& names_;
    bool adaptive_;
    int x0_, y0_;
    std::span<Pixel> pixels_;
    Counters& counters_;
    std::vector<RecordedRay>* recorded_;
    std::vector<WaveTracer::Request> requests_;
    std::vector<Sample> samples_;
};

void trace_tile(WaveTracer& tracer, const RenderContext& context, int x0, int y0,
                std::span<Pixel> pixels, Counters& counters, std::vector<RecordedRay>* recorded) {
    static const auto order = morton_order();
    const RenderSettings& settings = context.settings;
    TileSampler sampler(tracer, context.names, settings.error > 0, x0, y0, pixels, counters,
                        recorded);
    std::vector<uint16_t> active(order.begin(), order.end());
    const int budget = settings.error > 0 ? settings.max_samples : settings.samples;
    const bool by_contrast = settings.error > 0 && !context.needs.noise;
    int done = 0;
    if (by_contrast) {
        sampler.sample(active, 0, 1);
        active = contrasting(sampler.ring(), settings.error, order);
        done = 1;
    }
    const int round = by_contrast ? samples_per_edge_round : samples_per_wave;
    while (done < budget && !active.empty()) {
        const int count = std::min(round, budget - done);
        sampler.sample(active, done, count);
        done += count;
        if (settings.error > 0) active = unconverged(pixels, settings.error, active);
    }
}

}  // namespace sightline
