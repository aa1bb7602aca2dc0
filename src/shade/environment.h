#pragma once
#include "scene/scene.h"
#include "shade/environment_kernel.h"

namespace sightline {

/// Light from infinitely far, as an equirectangular picture oriented as in three.js: the picture's
/// column at u (from the left) is direction (cos φ, ·, sin φ) with φ = 2π(u − ½); row 0 is +y.
class Environment {
  public:
    /// Takes RGB or grey, 8-bit sRGB or linear float; what is negative or not finite becomes 0.
    /// `rotation` turns it about +y, in radians. `importance` false skips the sampling tables.
    Environment(const Image& picture, float rotation, bool importance = true);

    using Sample = EnvironmentSample;

    /// Radiance from unit directions, bilinear, and the densities with which sample() takes them
    /// where `pdfs` is not empty. In batches, since most of the time goes to waiting for memory.
    void look_up(std::span<const Vec3> directions, std::span<Vec3> radiance,
                 std::span<float> pdfs) const;
    Vec3 radiance(const Vec3& d) const;
    /// The mean over the sphere of directions, from 1024 of them.
    Vec3 mean_radiance() const;
    float pdf(const Vec3& d) const;  ///< per solid angle

    /// Directions with density in proportion to luminance, bilinear within texels too, from points
    /// in [0,1)².
    void sample(std::span<const float> u, std::span<const float> v,
                std::span<Sample> samples) const;
    Sample sample(Vec2 u) const;

    size_t memory() const;

  private:
    void build_tables();
    bool is_black() const;

    EnvironmentTables tables_;
};

/// The neutral built-in studio: a soft overhead light, two side lights and a grey surround.
Image studio_picture();

}  // namespace sightline
