#include "image/flip.h"

#include "core/math.h"
#include "core/srgb.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace sightline {
namespace {

// Section and equation numbers below are those of the paper.

constexpr float pixels_per_degree = 67.0206f;  // 0.7 m from a screen 0.7 m wide with 3840 pixels

/// A value per pixel, row by row.
struct Plane {
    int width, height;
    std::vector<float> values;

    Plane(int w, int h)
        : width(w), height(h), values(static_cast<size_t>(w) * static_cast<size_t>(h)) {}
};

/// Weights at -r … r.
using Kernel = std::vector<float>;

template <class Function>
Kernel make_kernel(int radius, const Function& weight) {
    Kernel kernel;
    for (int i = -radius; i <= radius; ++i) kernel.push_back(weight(static_cast<float>(i)));
    return kernel;
}

float sum(const Kernel& kernel) {
    float total = 0;
    for (const float w : kernel) total += w;
    return total;
}

/// Positive weights sum to 1 and negative ones to -1.
Kernel normalized(Kernel kernel) {
    float positive = 0, negative = 0;
    for (const float w : kernel) (w > 0 ? positive : negative) += w;
    for (float& w : kernel) w /= w > 0 ? positive : -negative;
    return kernel;
}

/// One pass of a separable filter; pixels beyond the edges equal those at the edges.
Plane filter_rows(const Plane& in, const Kernel& kernel) {
    Plane out(in.width, in.height);
    const int radius = static_cast<int>(kernel.size() / 2);
    std::vector<float> row(static_cast<size_t>(in.width + 2 * radius));
    for (int y = 0; y < in.height; ++y) {
        const size_t start = static_cast<size_t>(y) * static_cast<size_t>(in.width);
        for (int x = -radius; x < in.width + radius; ++x) {
            const auto from = static_cast<size_t>(std::clamp(x, 0, in.width - 1));
            row[static_cast<size_t>(x + radius)] = in.values[start + from];
        }
        for (size_t x = 0; x < static_cast<size_t>(in.width); ++x) {
            float total = 0;
            for (size_t k = 0; k < kernel.size(); ++k) total += kernel[k] * row[x + k];
            out.values[start + x] = total;
        }
    }
    return out;
}

Plane transposed(const Plane& in) {
    Plane out(in.height, in.width);
    const auto width = static_cast<size_t>(in.width), height = static_cast<size_t>(in.height);
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) out.values[x * height + y] = in.values[y * width + x];
    return out;
}

Plane filter(const Plane& in, const Kernel& along_x, const Kernel& along_y) {
    return transposed(filter_rows(transposed(filter_rows(in, along_x)), along_y));
}

// Colour spaces (4.1, appendix). White is linear RGB (1,1,1), which is D65.

// From the primaries' chromaticities in IEC 61966-2-1 and white (0.3127, 0.3290).
constexpr float to_xyz[3][3] = {{0.41238656f, 0.35759149f, 0.18045049f},
                                {0.21263682f, 0.71518298f, 0.07218020f},
                                {0.01933062f, 0.11919716f, 0.95037259f}};
constexpr float to_rgb[3][3] = {{3.24100323f, -1.53739897f, -0.49861588f},
                                {-0.96922425f, 1.87592998f, 0.04155423f},
                                {0.05563942f, -0.20401121f, 1.05714898f}};

Vec3 multiply(const float (&m)[3][3], const Vec3& v) {
    const auto row = [&](int i) { return m[i][0] * v.x + m[i][1] * v.y + m[i][2] * v.z; };
    return {row(0), row(1), row(2)};
}

const Vec3 white = multiply(to_xyz, Vec3(1));

Vec3 to_ycxcz(const Vec3& rgb) {
    const Vec3 t = multiply(to_xyz, rgb) / white;
    return {116 * t.y - 16, 500 * (t.x - t.y), 200 * (t.y - t.z)};
}

Vec3 from_ycxcz(const Vec3& c) {
    const float y = (c.x + 16) / 116;
    return multiply(to_rgb, Vec3(y + c.y / 500, y, y - c.z / 200) * white);
}

/// CIELab, with chroma scaled by luminance for the Hunt effect (4.1.3).
Vec3 to_hunt_lab(const Vec3& rgb) {
    const auto f = [](float t) {
        constexpr float delta = 6.0f / 29;
        return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0f / 29;
    };
    const Vec3 t = multiply(to_xyz, rgb) / white;
    const float fx = f(t.x), fy = f(t.y), fz = f(t.z), lightness = 116 * fy - 16;
    return {lightness, 0.01f * lightness * 500 * (fx - fy), 0.01f * lightness * 200 * (fy - fz)};
}

/// The HyAB distance (4.1.4) with its exponent (4.1.5).
float color_distance(const Vec3& a, const Vec3& b) {
    const Vec3 d = a - b;
    return std::pow(std::fabs(d.x) + std::hypot(d.y, d.z), 0.7f);
}

/// Distances mapped to [0,1]: the lower 40 % of them take 95 % of the range (4.1.5).
float remapped(float distance) {
    static const float largest =
        color_distance(to_hunt_lab(Vec3(0, 1, 0)), to_hunt_lab(Vec3(0, 0, 1)));
    const float knee = 0.4f * largest, at_knee = 0.95f;
    return distance < knee ? at_knee * distance / knee
                           : at_knee + (distance - knee) / (largest - knee) * (1 - at_knee);
}

/// An image as three planes of YCxCz.
struct Opponents {
    Plane y, cx, cz;
};

Opponents opponents_of(const Image& image) {
    const bool bytes = image.floats.empty();
    const auto value = [&](size_t i) {
        if (bytes) return decode_srgb(static_cast<float>(image.bytes[i]) / 255);
        return image.floats[i] > 0 ? std::min(image.floats[i], 1.0f) : 0.0f;
    };
    const size_t channels = static_cast<size_t>(image.channels);
    const size_t green = channels < 3 ? 0 : 1, blue = channels < 3 ? 0 : 2;
    const Plane empty(image.width, image.height);
    Opponents result{empty, empty, empty};
    for (size_t i = 0; i < empty.values.size(); ++i) {
        const size_t at = i * channels;
        const Vec3 c = to_ycxcz({value(at), value(at + green), value(at + blue)});
        result.y.values[i] = c.x;
        result.cx.values[i] = c.y;
        result.cz.values[i] = c.z;
    }
    return result;
}

/// A Gaussian of the contrast sensitivity functions (4.1.1, table 1), x in degrees:
/// a √(π/b) exp(-π²x²/b).
struct Sensitivity {
    float a, b;
};

/// The plane filtered by a sum of Gaussians, normalised to sum 1.
Plane filter_contrast(const Plane& plane, std::initializer_list<Sensitivity> gaussians) {
    constexpr float widest = 0.04f;
    const int radius =
        static_cast<int>(std::ceil(3 * std::sqrt(widest / (2 * pi * pi)) * pixels_per_degree));
    Plane result(plane.width, plane.height);
    float total = 0;
    for (const auto& [a, b] : gaussians) {
        Kernel kernel = make_kernel(radius, [b = b](float i) {
            const float x = i / pixels_per_degree;
            return std::exp(-pi * pi * x * x / b);
        });
        const float weight = a * std::sqrt(pi / b) * sum(kernel) * sum(kernel);
        kernel = normalized(std::move(kernel));
        const Plane part = filter(plane, kernel, kernel);
        for (size_t i = 0; i < result.values.size(); ++i)
            result.values[i] += weight * part.values[i];
        total += weight;
    }
    for (float& v : result.values) v /= total;
    return result;
}

/// The image's colours after the eye's contrast sensitivity, in Hunt-adjusted Lab.
std::vector<Vec3> perceived_colors(const Opponents& image) {
    const Plane y = filter_contrast(image.y, {{1, 0.0047f}});
    const Plane cx = filter_contrast(image.cx, {{1, 0.0053f}});
    const Plane cz = filter_contrast(image.cz, {{34.1f, 0.04f}, {13.5f, 0.025f}});
    std::vector<Vec3> colors;
    colors.reserve(y.values.size());
    for (size_t i = 0; i < y.values.size(); ++i) {
        const Vec3 rgb = from_ycxcz({y.values[i], cx.values[i], cz.values[i]});
        const auto unit = [](float v) { return std::clamp(v, 0.0f, 1.0f); };
        colors.push_back(to_hunt_lab({unit(rgb.x), unit(rgb.y), unit(rgb.z)}));
    }
    return colors;
}

/// The strength of edges and points at each pixel (4.2).
struct Features {
    Plane edges, points;
};

Plane magnitude(const Plane& plane, const Kernel& derivative, const Kernel& smooth) {
    Plane result = filter(plane, derivative, smooth);
    const Plane across = filter(plane, smooth, derivative);
    for (size_t i = 0; i < result.values.size(); ++i)
        result.values[i] = std::hypot(result.values[i], across.values[i]);
    return result;
}

Features features_of(const Opponents& image) {
    constexpr float feature_width = 0.082f;  // degrees
    const float deviation = 0.5f * feature_width * pixels_per_degree;
    const int radius = static_cast<int>(std::ceil(3 * deviation));
    const auto bell = [&](float x) { return std::exp(-x * x / (2 * deviation * deviation)); };
    const Kernel smooth = normalized(make_kernel(radius, bell));
    const Kernel first = normalized(make_kernel(radius, [&](float x) { return -x * bell(x); }));
    const Kernel second = normalized(make_kernel(
        radius, [&](float x) { return (x * x / (deviation * deviation) - 1) * bell(x); }));
    Plane luminance = image.y;
    for (float& v : luminance.values) v = (v + 16) / 116;
    return {magnitude(luminance, first, smooth), magnitude(luminance, second, smooth)};
}

}  // namespace

std::vector<float> flip(const Image& reference, const Image& test) {
    assert(reference.width == test.width && reference.height == test.height);
    const Opponents a = opponents_of(reference), b = opponents_of(test);
    const std::vector<Vec3> colors_a = perceived_colors(a), colors_b = perceived_colors(b);
    const Features features_a = features_of(a), features_b = features_of(b);
    std::vector<float> result;
    result.reserve(colors_a.size());
    for (size_t i = 0; i < colors_a.size(); ++i) {
        const float color = remapped(color_distance(colors_a[i], colors_b[i]));
        const float edge = std::fabs(features_a.edges.values[i] - features_b.edges.values[i]);
        const float point = std::fabs(features_a.points.values[i] - features_b.points.values[i]);
        const float feature = std::sqrt(std::fmax(edge, point) / std::sqrt(2.0f));
        result.push_back(std::pow(color, 1 - feature));
    }
    return result;
}

}  // namespace sightline
