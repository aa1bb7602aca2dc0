#pragma once
// Images of the surfaces that engines and referee report, and of wrong answers, by pixel.
#include "image/image.h"
#include "lab/compare/compare.h"
#include "render/film.h"

namespace sightline {

/// An image of the size of the film's window.
struct ScreenMap {
    std::string name;
    Image image;
};

/// One map per engine, and last one for the referee, named "referee": a colour for the surface that
/// each pixel's first camera ray hits, with the brightness of `picture` (8-bit RGB). Empty if the
/// rays have no pixels, as those from a file.
std::vector<ScreenMap> surface_maps(const Referee& referee, std::span<const RecordedRay> rays,
                                    std::span<const Engine* const> engines, const PixelRect& window,
                                    const Image& picture);

/// One map per engine of the pixels with a finding for any ray: red if the engine is wrong, yellow
/// for other findings; transparent elsewhere.
std::vector<ScreenMap> finding_maps(const Comparison& comparison, std::span<const RecordedRay> rays,
                                    const PixelRect& window);

}  // namespace sightline
