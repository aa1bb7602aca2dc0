#pragma once
// The grids of the albedo tables and the interpolation in them: for albedo.cpp, which reads the
// tables, and for tools/make_albedo_tables.cpp, which computes them when the program is built.
#include "shade/albedo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace sightline {

/// A position on an axis of equidistant nodes 0…n−1: the node below it and the fraction towards the
/// next one.
struct GridPosition {
    size_t node;
    float fraction;

    /// `x` in [0,1] is the share of the axis; what is outside is clamped.
    static GridPosition on_axis(float x, size_t nodes) {
        // In this form compilers need no branches.
        const float share = std::min(std::max(0.0f, x), 1.0f);
        const float scaled = share * static_cast<float>(nodes - 1);
        const int node = std::min(static_cast<int>(scaled), static_cast<int>(nodes) - 2);
        return {static_cast<size_t>(node), scaled - static_cast<float>(node)};
    }
};

/// Values of `width` floats on a grid with the given numbers of nodes, interpolated linearly along
/// each axis. The last axis is contiguous.
template <size_t width, size_t... nodes>
struct AlbedoTable {
    static constexpr size_t axes = sizeof...(nodes);
    static constexpr std::array<size_t, axes> shape{nodes...};
    static constexpr size_t size = width * (nodes * ...);
    using Value = std::array<float, width>;
    using Position = std::array<float, axes>;  ///< the share of each axis, in [0,1]

    const float* values;

    Value operator()(const Position& x) const {
        std::array<GridPosition, axes> at;
        for (size_t a = 0; a < axes; ++a) at[a] = GridPosition::on_axis(x[a], shape[a]);
        return interpolate<0>(at, 0);
    }

  private:
    template <size_t axis>
    Value interpolate(const std::array<GridPosition, axes>& at, size_t row) const {
        const size_t index = row * shape[axis] + at[axis].node;
        Value low, high;
        if constexpr (axis + 1 == axes) {
            const float* first = values + index * width;
            std::copy_n(first, width, low.begin());
            std::copy_n(first + width, width, high.begin());
        } else {
            low = interpolate<axis + 1>(at, index);
            high = interpolate<axis + 1>(at, index + 1);
        }
        for (size_t i = 0; i < width; ++i) low[i] += (high[i] - low[i]) * at[axis].fraction;
        return low;
    }
};

/// E of a white GGX lobe by roughness and cosine.
using GgxTable = AlbedoTable<1, 32, 48>;
/// The same, and the offset of the cosine of reflection in units of alpha, for `usual_ior`: what
/// most lookups need, with a quarter of the values that three axes take.
using UsualTable = AlbedoTable<2, 32, 48>;
/// What a dielectric does to light from the side of the smaller index, by index, roughness and
/// cosine: the offset of the cosine of reflection, in units of alpha; the share T of a refraction
/// that all facets permit; the offset of the cosine of refraction.
using EnteringTable = AlbedoTable<1, 10, 24, 32>;
/// The same for light from the side of the larger index: the shares of E that are reflected and
/// totally reflected, T, and what Fresnel's equations take from T.
using LeavingTable = AlbedoTable<4, 26, 18, 33>;
/// E of a GGX lobe that is stretched along a tangent, by strength, roughness, direction and cosine;
/// and the offset of its cosine of reflection, in units of the larger alpha.
using StretchedTable = AlbedoTable<1, 9, 17, 10, 24>;
/// Albedo of a white sheen by roughness and cosine; and the ratio to it, or to 1 if that is less,
/// of the sheen's that is divided by the larger of 1 and its albedos.
using SheenTable = AlbedoTable<1, 48, 57>;

/// Smallest alpha in the tables. Below it they change no more as functions of `ggx_axis`.
inline constexpr float least_table_alpha = 3e-4f;

/// The axis of cosines for a lobe of this alpha, which has its detail where the cosine is as small
/// as alpha.
inline float ggx_axis(float cosine, float alpha) { return cosine * (1 + alpha) / (cosine + alpha); }
inline float ggx_axis_cosine(float x, float alpha) { return x * alpha / (1 + alpha - x); }

/// The axis of the ratio of two refractive indices, the larger one over the smaller one: fine near
/// 1, where the reflectance depends on the root of the difference.
inline constexpr float last_ior_axis = 0.7f;
inline float ior_axis(float eta) { return std::sqrt((eta - 1) / (eta + 1)) / last_ior_axis; }
inline float ior_axis_eta(float x) {
    const float root = x * last_ior_axis;
    return (1 + root * root) / (1 - root * root);
}

/// The axis of cosines on the side of the larger index. The critical angle is in the middle.
inline float leaving_axis(float cosine, float critical) {
    if (cosine < critical) return 0.5f * cosine / critical;
    return 0.5f + 0.5f * std::sqrt((cosine - critical) / (1 - critical));
}
inline float leaving_axis_cosine(float x, float critical) {
    if (x < 0.5f) return 2 * x * critical;
    return critical + (1 - critical) * (2 * x - 1) * (2 * x - 1);
}

/// The axis of the smaller alpha of a stretched lobe.
inline float stretched_axis(float across) { return std::sqrt(std::sqrt(across)); }
inline float stretched_axis_alpha(float x) {
    return std::max(std::pow(x, 4.0f), least_table_alpha);
}

/// The axis of the alpha along a direction, from the smaller to the larger one of a stretched lobe.
inline float turn_axis(float alpha, float along, float across) {
    return along > across ? std::sqrt(std::max(0.0f, (alpha - across) / (along - across))) : 0;
}
inline float turn_axis_alpha(float x, float along, float across) {
    return across + (along - across) * x * x;
}

/// The axis of cosines of a sheen, which is brightest at grazing angles.
inline float sheen_axis(float cosine) { return std::sqrt(std::max(cosine, 0.0f)); }
inline float sheen_axis_cosine(float x) { return x * x; }

/// The axis of a sheen's perceptual roughness. Its alpha is never below 0.001.
inline constexpr float least_sheen_roughness = 0.0316f;
inline float sheen_roughness_axis(float roughness) {
    return std::sqrt(std::max(roughness - least_sheen_roughness, 0.0f) /
                     (1 - least_sheen_roughness));
}
inline float sheen_axis_roughness(float x) {
    return least_sheen_roughness + (1 - least_sheen_roughness) * x * x;
}

/// The larger of 1 and the two albedos of an undivided sheen: by this number the lobe is divided.
inline float sheen_divisor(const SheenTable& undivided, float cos_i, float cos_o, float roughness) {
    const float row = sheen_roughness_axis(roughness);
    return std::max(
        {1.0f, undivided({row, sheen_axis(cos_i)})[0], undivided({row, sheen_axis(cos_o)})[0]});
}

}  // namespace sightline
