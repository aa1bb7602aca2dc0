#pragma once
// What engines and referee see, pixel by pixel.
#include "image/image.h"
#include "lab/compare/compare.h"
#include "render/film.h"

namespace sightline {

/// A picture of the size of the film's window.
struct ScreenMap {
    std::string name;
    Image image;
};

/// For one engine after the other, and last for the referee ("referee"): a colour for the surface
/// that each pixel's first camera ray meets, its brightness that of `picture` (8-bit RGB).
/// Empty where no ray knows its pixel.
std::vector<ScreenMap> surface_maps(const Referee& referee, std::span<const RecordedRay> rays,
                                    std::span<const Engine* const> engines, const PixelRect& window,
                                    const Image& picture);

/// For each engine the pixels with a finding by any ray: red where the engine is wrong, yellow
/// where floats or ties leave it open; transparent elsewhere. In the order of the engines.
std::vector<ScreenMap> finding_maps(const Comparison& comparison, std::span<const RecordedRay> rays,
                                    const PixelRect& window);

}  // namespace sightline
