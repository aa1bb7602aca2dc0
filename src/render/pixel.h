#pragma once
#include "render/cryptomatte.h"
#include "render/samples.h"

#include <array>

namespace sightline {

/// Sums of the luminance of a pixel's samples over the four quarters of their sequence. After 4, 8,
/// 16 … samples each quarter is full: a stratified set of points of its own, so that the means of
/// the quarters show the error of such sets, which is below that of independent samples.
class QuarterSums {
  public:
    /// Adds the next sample's finite_luminance.
    void add(double luminance);

    /// The mean's estimated variance in what a display shows, relative to the square of the mean
    /// plus dark_floor. The quarters must be full.
    double relative_variance() const;

  private:
    std::array<double, 4> sums_{};
    uint32_t samples_ = 0, per_quarter_ = 1;
};

/// Errors of darker pixels count as those of a pixel that is this bright on the display.
inline constexpr double dark_floor = 0.25;

/// Sums over the samples of one pixel.
struct Pixel {
    Vec3 radiance{0, 0, 0};
    float alpha = 0;
    Vec3 shown{0, 0, 0};  ///< the part of radiance that the tone map leaves alone
    float shown_share = 0;
    Vec3 through{0, 0, 0};  ///< the part of a transparent background that is seen
    float through_share = 0;
    Vec3 normal{0, 0, 0}, albedo{0, 0, 0};
    FirstHit first;  ///< of the pixel's first sample
    uint32_t samples = 0;
    uint64_t rays = 0;
    QuarterSums luminance;     ///< with settings.error
    std::vector<Vec3> lights;  ///< radiance by light group; empty without that layer
    std::vector<Coverage> objects, materials;  ///< Cryptomatte's; empty without that layer
};

/// Luminance; what is not finite counts as very bright.
double finite_luminance(const Vec3& c);

/// Luminance Y as Y / (1 + Y), close to what a display shows of it: errors in highlights count
/// less.
double display_luminance(const Vec3& c);

/// Adds one sample of the pixel to its sums, with its light groups.
void add_sample(Pixel& pixel, const SampleBuffer& buffer, size_t slot);

/// Adds what a surface covers of one sample, by Cryptomatte's ids.
void add_coverage(Pixel& pixel, uint32_t object_id, uint32_t material_id, float coverage);

/// Rays after which the relative error of a pixel of ordinary noise is as given.
double ordinary_rays(float error);

/// Whether a pixel that has cost `rays` so far needs more samples with settings.error.
///
/// One tolerance for all pixels would spend most rays where they change least. A perceived
/// difference grows as e^0.7 with the error e (Andersson et al. 2020, section 4.1.5), and e falls
/// at least as rays^-1/2. The picture's mean is least for its rays if one more ray changes it
/// equally everywhere, which holds if e^0.7 / rays is the same: the tolerance grows as
/// rays^(1/0.7), here rays^3/2. A pixel of ordinary noise, which takes 0.1 / error² rays, gets
/// `error` itself:
///
///   tolerance = error · (rays · error² / 0.1)^3/2
///
/// With these numbers the root mean square of a picture's relative errors is below `error`.
bool needs_samples(double relative_variance, uint64_t rays, float error);

}  // namespace sightline
