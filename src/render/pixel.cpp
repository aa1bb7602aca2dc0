#include "render/pixel.h"

#include <algorithm>

namespace sightline {

double display_luminance(const Vec3& c) {
    const double y = static_cast<double>(luminance(c));
    return y / (1 + y);
}

void add_sample(Pixel& pixel, const SampleBuffer& buffer, size_t slot) {
    const Sample& sample = buffer.samples[slot];
    if (pixel.samples == 0) pixel.first = sample.first;
    pixel.radiance += sample.radiance;
    pixel.alpha += sample.alpha;
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

void add_to_estimate(Pixel& pixel, const Sample& sample) {
    const double value = display_luminance(sample.radiance);
    const double delta = value - pixel.mean;
    pixel.mean += delta / pixel.samples;
    pixel.squares += delta * (value - pixel.mean);
}

// With n samples x of mean m:  s² = Σ (x − m)² / (n − 1),  standard error = √(s² / n).
bool is_converged(const Pixel& pixel, float error) {
    constexpr uint32_t least_samples = 4;
    if (pixel.samples < least_samples) return false;
    const double n = pixel.samples;
    const double standard_error = std::sqrt(pixel.squares / (n - 1) / n);
    return standard_error <= static_cast<double>(error) * std::max(pixel.mean, 0.01);
}

}  // namespace sightline
