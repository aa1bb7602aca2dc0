#pragma once
#include "render/film.h"
#include "render/tile.h"

namespace sightline {

/// The settings's channels, without values: beauty, alpha and the layers that it asks for.
Film layout_of(const RenderSettings& settings, const LayerNames& names);

/// Writes one pixel's means into the film's channels at (x, y), which lies in its window.
/// The film must have the channels of layout_of with the same names.
void develop(Film& film, const LayerNames& names, int x, int y, const Pixel& pixel);

}  // namespace sightline
