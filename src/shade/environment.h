#pragma once
#include "scene/scene.h"

#include <vector>

namespace sightline {

/// Light from infinitely far, as an equirectangular picture oriented as in three.js: the picture's
/// column at u (from the left) is direction (cos φ, ·, sin φ) with φ = 2π(u − ½); row 0 is +y.
class Environment {
  public:
    /// Takes RGB or grey, 8-bit sRGB or linear float; what is negative or not finite becomes 0.
    /// `rotation` turns it about +y, in radians. `importance` false skips the sampling tables.
    Environment(const Image& picture, float rotation, bool importance = true);

    /// Radiance from unit direction `d`, bilinear.
    Vec3 radiance(const Vec3& d) const;

    struct Sample {
        Vec3 wi;
        Vec3 radiance;
        float pdf;  ///< per solid angle; 0: nothing to sample
    };
    /// A direction with density in proportion to luminance, bilinear within texels too.
    Sample sample(Vec2 u) const;
    /// The density with which sample() takes unit direction `d`.
    float pdf(const Vec3& d) const;

    size_t memory() const;

  private:
    Vec2 picture_uv(const Vec3& d) const;
    Vec3 lookup(float x, float y) const;
    const Vec3& texel(int x, int y) const {
        return pixels_[static_cast<size_t>(y) * static_cast<size_t>(width_) +
                       static_cast<size_t>(x)];
    }
    void build_tables();
    float density(float luminance, int row, float sine) const;

    int width_, height_;
    std::vector<Vec3> pixels_;
    float cos_rotation_, sin_rotation_;
    // Cells lie between the centres of texels: row r between texel rows r−1 and r, half as high at
    // the poles; column c between texel columns c−1 and c, around the seam too.
    std::vector<float> marginal_;     // cumulative power of rows, height + 1
    std::vector<uint32_t> guides_;    // into marginal_, then into each row of conditional_
    std::vector<float> conditional_;  // cumulative luminance within each row, width values each
    std::vector<float> row_density_;  // solid-angle density · sin θ of unit luminance
};

/// The neutral built-in studio: a soft overhead light, two side lights and a grey surround.
Image studio_picture();

}  // namespace sightline
