#pragma once
#include "image/color_view.h"
#include "image/image.h"
#include "render/film.h"

namespace sightline {

enum class ToneMap { linear, pbr_neutral, aces, agx };

/// One linear Rec. 709 colour through the tone map, still linear, in [0,1] for all but `linear`.
Vec3 tone_map(ToneMap map, const Vec3& color);

/// A tone map, or a view of OpenColorIO in its place.
struct DisplayTransform {
    ToneMap map = ToneMap::pbr_neutral;
    const ColorView* view = nullptr;

    DisplayTransform(ToneMap tone_map) : map(tone_map) {}
    DisplayTransform(ToneMap tone_map, const ColorView* color_view)
        : map(tone_map), view(color_view) {}

    /// Linear Rec. 709, of which a display gets the sRGB code values.
    Vec3 operator()(const Vec3& color) const;
};

/// The beauty layer as an 8-bit RGB(A) picture over the film's window: times 2^exposure, tone
/// mapped, sRGB. What the layer shown_layer holds of it is neither exposed nor tone mapped: it is
/// shown by its own code values, in its share of the pixel. With `alpha`: RGBA, unpremultiplied.
/// Of a film with the layer through_layer, alpha is not coverage but fitted: laid over `backdrop`,
/// in code values, the picture is the one that has this colour as its background, and over black
/// nearly that with a black one.
Image display_picture(const Film& film, const DisplayTransform& map, float exposure, bool alpha,
                      const Vec3& backdrop = Vec3(1));

/// The beauty layer as linear floats (for .hdr).
Image linear_picture(const Film& film, float exposure);

}  // namespace sightline
