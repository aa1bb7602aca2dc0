#pragma once
#include "render/cryptomatte.h"
#include "render/wave_tracer.h"

namespace sightline {

inline constexpr int tile_size = 16;  ///< pixels; a wave of 16 samples each is 4096 rays

/// What the samples of one pixel add up to.
struct Pixel {
    Vec3 radiance{0, 0, 0};
    float alpha = 0;
    Vec3 normal{0, 0, 0}, albedo{0, 0, 0};
    FirstHit first;  ///< of the pixel's first sample
    uint32_t samples = 0;
    uint64_t rays = 0;
    double mean = 0, squares = 0;  ///< of display luminance, Welford's running sums: with `error`
    std::vector<Vec3> lights;      ///< radiance by light group, where asked for
    std::vector<Coverage> objects, materials;  ///< Cryptomatte's, where asked for
};

/// Traces all samples of the tile whose first pixel is (x0, y0), whole, whatever the crop.
/// `pixels` has tile_size² entries, row by row. With RenderSettings::error a pixel is done when its
/// standard error is below; a picture without noise is sampled once, and again where neighbours
/// differ by more than the error (Whitted 1980, section 4).
void trace_tile(WaveTracer& tracer, const RenderContext& context, int x0, int y0,
                std::span<Pixel> pixels, Counters& counters, std::vector<RecordedRay>* recorded);

}  // namespace sightline
