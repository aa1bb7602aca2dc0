#pragma once
#include "image/image.h"

namespace sightline {

/// Writes `image` as .png, .jpg, .tif, .webp or .hdr, chosen by the path's extension, atomically
/// (see core/files.h). Throws Error.
void write_image(const std::string& path, const Image& image);

}  // namespace sightline
