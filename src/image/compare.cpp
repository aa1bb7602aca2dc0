#include "image/compare.h"

#include "core/error.h"
#include "image/flip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace sightline {
namespace {

std::string shape_of(const Image& image) {
    return fmt::format("{} x {} x {} {}", image.width, image.height, image.channels,
                       image.floats.empty() ? "bytes" : "floats");
}

double distance(float a, float b) {
    if (a == b) return 0;
    const double difference = std::fabs(static_cast<double>(a) - static_cast<double>(b));
    return std::isfinite(difference) ? difference : std::numeric_limits<double>::infinity();
}

}  // namespace

Difference compare_images(const Image& a, const Image& b) {
    if (shape_of(a) != shape_of(b) || a.empty())
        throw Error(fmt::format("cannot compare images of {} and {}", shape_of(a), shape_of(b)));
    Difference result;
    double squares = 0;
    const auto add = [&](double difference) {
        squares += difference * difference;
        result.max_abs = std::max(result.max_abs, difference);
    };
    for (size_t i = 0; i < a.bytes.size(); ++i) add(std::abs(a.bytes[i] - b.bytes[i]) / 255.0);
    for (size_t i = 0; i < a.floats.size(); ++i) {
        if (!std::isfinite(a.floats[i]) || !std::isfinite(b.floats[i])) ++result.nonfinite;
        add(distance(a.floats[i], b.floats[i]));
    }
    result.rmse = std::sqrt(squares / static_cast<double>(a.bytes.size() + a.floats.size()));
    const std::vector<float> errors = flip(a, b);
    result.flip_mean =
        std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
    return result;
}

}  // namespace sightline
