#pragma once
#include "image/image.h"

#include <span>
#include <string>

namespace sightline {

/// The names of the built-in lights: studio, softbox, three-point, outdoor.
std::span<const std::string> light_names();

/// A built-in light as an environment, linear; all have the same mean radiance, and none depends on
/// the size of what it lights. "studio": a soft light overhead, two at the sides and grey walls.
/// "softbox": one large soft light from the upper left, and dark walls. "three-point": key, fill
/// and rim light. "outdoor": sun, sky and ground.
Image light_image(const std::string& name);

}  // namespace sightline
