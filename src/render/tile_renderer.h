#pragma once
#include "render/pixel.h"
#include "render/wave_tracer.h"

namespace sightline {

inline constexpr int tile_size = 16;  ///< pixels; a wave of 16 samples each is 4096 rays

/// Renders tiles, one at a time; one per thread, so that its arrays are allocated once.
class TileRenderer {
  public:
    explicit TileRenderer(const RenderContext& context) : context_(context), tracer_(context) {}

    /// Renders the tile whose first pixel is (x0, y0) and writes those of its pixels that lie in
    /// the film's window; all of them are traced. `recorded` may be null. A pixel gets
    /// settings.samples samples. With settings.error it gets a first round, and twice as many
    /// samples as before while needs_samples says so; in a picture without noise, one sample, and
    /// more where neighbours differ by more than the error (Whitted 1980, section 4).
    void render(int x0, int y0, Film& film, Counters& counters, std::vector<RecordedRay>* recorded);

  private:
    void refine();
    void add_samples(std::span<const uint16_t> active, int begin, int end);
    void add_wave(std::span<const uint16_t> active, int first, int count);
    std::vector<uint16_t> noisy_pixels(std::span<const uint16_t> active, int done);
    std::vector<uint16_t> contrasting_pixels();
    void request_sample(int x, int y, int index) {
        requests_.push_back({x0_ + x, y0_ + y, static_cast<uint32_t>(index)});
    }
    const SampleBuffer& trace() { return tracer_.trace(requests_, *counters_, recorded_); }

    const RenderContext& context_;
    WaveTracer tracer_;
    std::vector<SampleRequest> requests_;
    int x0_ = 0, y0_ = 0;
    std::array<Pixel, tile_size * tile_size> pixels_;      // row by row
    std::array<double, tile_size * tile_size> variances_;  // by pixel, the latest known
    Counters* counters_ = nullptr;
    std::vector<RecordedRay>* recorded_ = nullptr;
};

}  // namespace sightline
