#pragma once
#include "image/image.h"
#include "render/film.h"

namespace sightline {

enum class ToneMap { linear, pbr_neutral, aces, agx };

/// One linear Rec. 709 colour through the tone map, still linear, in [0,1] for all but `linear`.
Vec3 tone_map(ToneMap map, const Vec3& color);

/// The beauty layer as an 8-bit RGB(A) picture over the film's window: times 2^exposure, tone
/// mapped, sRGB. What the layer shown_layer holds of it is neither exposed nor tone mapped: it is
/// shown by its own code values, in its share of the pixel. With `alpha`: RGBA, unpremultiplied.
Image display_picture(const Film& film, ToneMap map, float exposure, bool alpha);

/// The beauty layer as linear floats (for .hdr).
Image linear_picture(const Film& film, float exposure);

}  // namespace sightline
