#pragma once
#include "image/image.h"

namespace sightline {

/// The built-in studio environment: a soft light overhead, two at the sides and grey walls. Linear.
Image studio_image();

}  // namespace sightline
