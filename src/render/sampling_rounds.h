#pragma once
// Rounds of samples: one with a fixed number of samples; with settings.error as many as a pixel
// needs.
#include "render/needs.h"

namespace sightline {

/// Samples that every pixel gets: all, or with settings.error those before any pixel may have
/// converged, about half of those of a pixel of ordinary noise (4, 8 or 16; 1 without noise).
int samples_of_first_round(const RenderSettings& settings, const Needs& needs);

/// Samples of a pixel after the round to which its sample `index` belongs. Each sample of the round
/// covers its share of the pixel, which chooses how textures are filtered.
int samples_after_round(const RenderSettings& settings, const Needs& needs, uint32_t index);

}  // namespace sightline
