#pragma once
#include "core/math.h"

#include <string>

namespace sightline {

/// The linear Rec. 709 colour of a name ("white", CSS's basic names and a few more), of "#RRGGBB"
/// or "#RGB" (code values of sRGB), or of three linear numbers R,G,B from 0 to 1. Throws Error.
Vec3 parse_color(const std::string& text);

}  // namespace sightline
