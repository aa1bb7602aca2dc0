#pragma once
#include "render/film.h"
#include "render/tile.h"

namespace sightline {

/// A black film with the job's channels, beauty, alpha and the layers that it asks for, over
/// `window`.
Film make_film(const RenderJob& job, const PixelRect& window);

/// Writes one pixel's means into the film's channels at (x, y), which lies in its window.
void develop(Film& film, int x, int y, const Pixel& pixel);

}  // namespace sightline
