#pragma once
// The order of pixels in Radiance pictures. OpenImageIO returns them in the order of the file.
#include "image/image.h"

#include <optional>

namespace sightline {

/// The order in which a Radiance picture stores its pixels, from the resolution string at the end
/// of its header: "-Y 32 +X 64" are 32 rows from the top, each of 64 pixels from the left (Ward
/// 1991, "Real Pixels"; the other seven orders are turned or mirrored).
struct HdrOrientation {
    size_t at = 0;             ///< offset of the resolution string in the file
    size_t second_axis = 0;    ///< offset of the second axis, as of "+X"
    bool by_columns = false;   ///< its scanlines are columns of the picture
    bool from_right = false;   ///< columns, or the pixels of a row, begin at the right
    bool from_bottom = false;  ///< rows, or the pixels of a column, begin at the bottom

    bool is_upright() const { return !by_columns && !from_right && !from_bottom; }
};

/// The orientation of a Radiance file; empty if it has no valid resolution string.
std::optional<HdrOrientation> hdr_orientation(std::span<const std::byte> file);

/// The file with the resolution string of an upright picture, whose rows are the scanlines.
std::vector<std::byte> as_upright_hdr(std::span<const std::byte> file,
                                      const HdrOrientation& orientation);

/// The picture from its scanlines.
Image upright(const Image& scanlines, const HdrOrientation& orientation);

}  // namespace sightline
