#include "render/pixel.h"

#include <algorithm>
#include <cassert>

namespace sightline {

namespace {

constexpr double brightest_kept = 1e6;

double display_value(double luminance) { return luminance / (1 + luminance); }

}  // namespace

double display_luminance(const Vec3& c) { return display_value(finite_luminance(c)); }

double finite_luminance(const Vec3& c) {
    const auto y = static_cast<double>(luminance(c));
    return y < brightest_kept ? std::max(y, 0.0) : brightest_kept;
}

// Full quarters become the first half of the samples, so that the next ones start the third.
void QuarterSums::add(double luminance) {
    if (samples_ == 4 * per_quarter_) {
        sums_ = {sums_[0] + sums_[1], sums_[2] + sums_[3], 0, 0};
        per_quarter_ *= 2;
    }
    sums_[samples_++ / per_quarter_] += luminance;
}

// With k = 4 means v of the quarters and their mean m:  s² = Σ (v − m)² / (k − 1),  variance s² /
// k.
double QuarterSums::relative_variance() const {
    assert(samples_ == 4 * per_quarter_);
    std::array<double, 4> values;
    double mean = 0;
    for (size_t i = 0; i < values.size(); ++i) {
        values[i] = display_value(sums_[i] / per_quarter_);
        mean += values[i] / 4;
    }
    double squares = 0;
    for (const double v : values) squares += (v - mean) * (v - mean);
    const double scale = mean + dark_floor;
    return squares / (3 * 4 * scale * scale);
}

void add_sample(Pixel& pixel, const SampleBuffer& buffer, size_t slot) {
    const Sample& sample = buffer.samples[slot];
    if (pixel.samples == 0) pixel.first = sample.first;
    pixel.radiance += sample.radiance;
    pixel.alpha += sample.alpha;
    pixel.shown += sample.shown;
    pixel.shown_share += sample.shown_share;
    pixel.through += sample.through;
    pixel.through_share += sample.through_share;
    pixel.rays += sample.rays;
    if (sample.first.valid) {
        pixel.normal += sample.first.normal;
        pixel.albedo += sample.first.albedo;
    }
    ++pixel.samples;
    pixel.lights.resize(buffer.light_groups, Vec3(0, 0, 0));
    for (size_t g = 0; g < buffer.light_groups; ++g)
        pixel.lights[g] += buffer.light_by_group[slot * buffer.light_groups + g];
}

void add_coverage(Pixel& pixel, uint32_t object_id, uint32_t material_id, float coverage) {
    const auto add = [coverage](std::vector<Coverage>& sums, uint32_t id) {
        const auto found = std::ranges::find(sums, id, &Coverage::first);
        if (found == sums.end()) {
            sums.push_back({id, coverage});
        } else {
            found->second += coverage;
        }
    };
    add(pixel.objects, object_id);
    add(pixel.materials, material_id);
}

double ordinary_rays(float error) {
    return 0.1 / (static_cast<double>(error) * static_cast<double>(error));
}

bool needs_samples(double relative_variance, uint64_t rays, float error) {
    const double cost = static_cast<double>(rays) / ordinary_rays(error);
    const double e = static_cast<double>(error);
    return relative_variance > e * e * cost * cost * cost;
}

}  // namespace sightline
