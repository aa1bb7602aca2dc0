#pragma once
// Lookup and sampling of an environment for many directions at once, with SIMD.
#include "core/math.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sightline {

/// The image of an Environment and the tables for sampling it. The bilinear image is piecewise
/// smooth in cells, whose corners are the centres of texels: (height + 1) rows of `width` cells.
///
///                  texel columns
///                 c−1         c          cell row r lies between the texel rows r−1 and r,
///   texel   r−1    ×──────────×          cell column c between the texel columns c−1 and c;
///   rows           │ cell r,c │          column 0 crosses the seam, and the rows 0 and height, at
///           r      ×──────────×          the poles, are half as high and constant in height
///
/// Sampling picks a row of cells by `marginal`, a cell of it by `conditional`, and a point in the
/// cell by its bilinear luminance. The tables are cumulative sums and not normalised.
struct EnvironmentTables {
    int width = 0, height = 0;
    std::vector<Vec3> pixels;  ///< linear RGB, row by row
    float cos_rotation = 1, sin_rotation = 0;

    std::vector<float> marginal;     ///< of power, over the height + 1 rows
    std::vector<float> conditional;  ///< of luminance within each row: (height + 1) · width
    std::vector<float> row_density;  ///< by row: pdf per solid angle · sin θ, for luminance 1

    /// A guide splits the range of a cumulative table into `buckets` equal parts and holds the
    /// index at which each begins, so that a search touches one or two cache lines (Chen & Asau
    /// 1974, "On Generating Random Variates from an Empirical Distribution").
    static constexpr int buckets = 256;
    static constexpr int guide_size = buckets + 1;
    std::vector<int32_t> guides;  ///< of marginal, then of each row of conditional
};

/// A sampled direction, the radiance from it, and its pdf per solid angle.
struct EnvironmentSample {
    Vec3 wi;
    Vec3 radiance;
    float pdf;  ///< 0: nothing to sample
};

/// Radiance from unit directions, bilinear, and, unless `pdfs` is empty, the pdfs with which
/// sample_environment picks them; these need the tables for sampling.
void look_up_environment(const EnvironmentTables& tables, std::span<const Vec3> directions,
                         std::span<Vec3> radiance, std::span<float> pdfs);

/// Samples directions from points (u, v) in [0,1)², with a pdf in proportion to the luminance of
/// the bilinear image.
void sample_environment(const EnvironmentTables& tables, std::span<const float> u,
                        std::span<const float> v, std::span<EnvironmentSample> samples);

}  // namespace sightline
