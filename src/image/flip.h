#pragma once
#include "image/image.h"

namespace sightline {

/// The difference between a reference and a test picture of equal size as a person sees it who
/// flips between them, per pixel in [0,1]: LDR-FLIP (Andersson et al., "FLIP: A Difference
/// Evaluator for Alternating Images", 2020) at 67 pixels a degree. Bytes are sRGB, floats linear
/// and clamped to [0,1]; alpha is ignored and grey taken as RGB.
std::vector<float> flip(const Image& reference, const Image& test);

}  // namespace sightline
