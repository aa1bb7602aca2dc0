#pragma once
#include "image/image.h"

namespace sightline {

/// How far two pictures are apart. Values are as stored: bytes over 255, floats as they are.
struct Difference {
    double rmse = 0;       ///< root of the mean squared difference over all values
    double max_abs = 0;    ///< the largest difference
    size_t nonfinite = 0;  ///< values that are NaN or infinite in either picture
    double flip_mean = 0;  ///< mean of flip()
};

/// Compares two pictures of equal width, height, channels and type; throws Error where they are
/// not. A NaN, or an infinity that the other picture has not, makes `rmse` and `max_abs` infinite,
/// so that no tolerance lets it pass.
Difference compare_images(const Image& a, const Image& b);

}  // namespace sightline
