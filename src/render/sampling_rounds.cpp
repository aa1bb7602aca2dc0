#include "render/sampling_rounds.h"

#include "render/pixel.h"

#include <algorithm>
#include <bit>

namespace sightline {

int samples_of_first_round(const RenderSettings& settings, const Needs& needs) {
    constexpr double rays_per_sample = 4;
    if (!(settings.error > 0)) return settings.samples;
    if (!needs.noise) return 1;
    const double half = ordinary_rays(settings.error) / rays_per_sample / 2;
    return std::min(half < 8 ? 4 : half < 16 ? 8 : 16, settings.max_samples);
}

int samples_after_round(const RenderSettings& settings, const Needs& needs, uint32_t index) {
    const int first = samples_of_first_round(settings, needs);
    if (index < static_cast<uint32_t>(first)) return first;
    return std::max(static_cast<int>(std::bit_ceil(index + 1)), 4);
}

}  // namespace sightline
