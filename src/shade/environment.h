#pragma once
#include "scene/scene.h"

namespace sightline {

/// Light from infinitely far, as an equirectangular picture oriented as in three.js: the picture's
/// column at u (from the left) is direction (cos φ, ·, sin φ) with φ = 2π(u − ½); row 0 is +y.
class Environment {
  public:
    /// `rotation` turns it about +y, in radians. `importance` false skips the sampling tables.
    Environment(Image picture, float rotation, bool importance = true);

    /// Radiance from unit direction `d`, bilinear.
    Vec3 radiance(const Vec3& d) const;

    struct Sample {
        Vec3 wi;
        Vec3 radiance;
        float pdf;  ///< per solid angle
    };
    /// A direction with density in proportion to luminance.
    Sample sample(Vec2 u) const;
    float pdf(const Vec3& d) const;

    size_t memory() const;

  private:
    Image picture_;
    float cos_rotation_, sin_rotation_;
    std::vector<float> marginal_, conditional_;  // cumulative, by row and within rows
    float total_ = 0;
};

/// The neutral built-in studio: a soft overhead light, two side lights and a grey surround.
Image studio_picture();

}  // namespace sightline
