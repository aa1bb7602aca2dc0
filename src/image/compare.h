#pragma once
#include "image/image.h"

namespace sightline {

/// The difference of two images. Values are as stored: bytes divided by 255, floats unchanged.
struct Difference {
    double rmse = 0;       ///< root of the mean squared difference over all values
    double max_abs = 0;    ///< the largest difference
    size_t nonfinite = 0;  ///< values that are NaN or infinite in either image
    double flip_mean = 0;  ///< mean of flip()
};

/// Compares two images; throws Error unless width, height, channels and type are equal. A NaN, or
/// an infinity in one image only, makes `rmse` and `max_abs` infinite, so that it exceeds every
/// tolerance.
Difference compare_images(const Image& a, const Image& b);

}  // namespace sightline
