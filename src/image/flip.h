#pragma once
#include "image/image.h"

namespace sightline {

/// The perceived difference between a reference and a test image of equal size when flipping
/// between them, per pixel in [0,1]: LDR-FLIP (Andersson et al., "FLIP: A Difference Evaluator for
/// Alternating Images", 2020) at 67 pixels per degree. Bytes are sRGB, floats linear and clamped to
/// [0,1]; alpha is ignored, and grey is expanded to RGB.
std::vector<float> flip(const Image& reference, const Image& test);

}  // namespace sightline
