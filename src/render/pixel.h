#pragma once
#include "render/cryptomatte.h"
#include "render/samples.h"

namespace sightline {

/// Sums over the samples of one pixel.
struct Pixel {
    Vec3 radiance{0, 0, 0};
    float alpha = 0;
    Vec3 normal{0, 0, 0}, albedo{0, 0, 0};
    FirstHit first;  ///< of the pixel's first sample
    uint32_t samples = 0;
    uint64_t rays = 0;
    double mean = 0, squares = 0;  ///< see add_to_estimate
    std::vector<Vec3> lights;      ///< radiance by light group; empty without that layer
    std::vector<Coverage> objects, materials;  ///< Cryptomatte's; empty without that layer
};

/// Luminance Y as Y / (1 + Y), close to what a display shows of it: errors in highlights count
/// less.
double display_luminance(const Vec3& c);

/// Adds one sample of the pixel to its sums, with its light groups.
void add_sample(Pixel& pixel, const SampleBuffer& buffer, size_t slot);

/// Adds what a surface covers of one sample, by Cryptomatte's ids.
void add_coverage(Pixel& pixel, uint32_t object_id, uint32_t material_id, float coverage);

/// Updates the mean and the sum of squared deviations of the samples' display luminance (Welford
/// 1962). The sample has been added to the pixel.
void add_to_estimate(Pixel& pixel, const Sample& sample);

/// True if the standard error of the pixel's mean display luminance is at most `error` of the mean,
/// which counts as 1 % at least. False for fewer than four samples.
bool is_converged(const Pixel& pixel, float error);

}  // namespace sightline
