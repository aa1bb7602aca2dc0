#pragma once
// An environment's lookups and draws for many directions at once, in the vectors of the processor.
#include "core/math.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sightline {

/// What environment light is read and drawn from; see Environment. Cells lie between the centres of
/// texels: row r between texel rows r−1 and r, half as high at the poles; column c between texel
/// columns c−1 and c, around the seam too.
struct EnvironmentTables {
    /// Each row of a cumulative table comes with where equal parts of its range begin, so that a
    /// search touches one or two cache lines (Chen & Asau 1974, "On Generating Random Variates from
    /// an Empirical Distribution").
    static constexpr int buckets = 256;
    static constexpr int guide_size = buckets + 1;

    int width = 0, height = 0;
    std::vector<Vec3> pixels;
    float cos_rotation = 1, sin_rotation = 0;
    std::vector<float> marginal;     ///< cumulative power of rows, height + 1
    std::vector<int32_t> guides;     ///< into marginal, then into each row of conditional
    std::vector<float> conditional;  ///< cumulative luminance within each row, width values each
    std::vector<float> row_density;  ///< solid-angle density · sin θ of unit luminance
};

/// A direction, what comes from there, and the density per solid angle with which it was drawn.
struct EnvironmentSample {
    Vec3 wi;
    Vec3 radiance;
    float pdf;  ///< 0: nothing to sample
};

/// Radiance from unit directions, bilinear; and, where `pdfs` is not empty (which needs the tables
/// for sampling), the density with which `sample_environment` draws them.
void look_up_environment(const EnvironmentTables& tables, std::span<const Vec3> directions,
                         std::span<Vec3> radiance, std::span<float> pdfs);

/// Directions with density in proportion to luminance, bilinear within texels too.
void sample_environment(const EnvironmentTables& tables, std::span<const float> u,
                        std::span<const float> v, std::span<EnvironmentSample> samples);

}  // namespace sightline
