#pragma once
#include "scene/scene.h"
#include "shade/environment_kernel.h"

#include <functional>

namespace sightline {

/// Light from infinitely far, as an equirectangular image with the orientation of three.js: the
/// column at u (from the left) is the direction (cos φ, ·, sin φ) with φ = 2π(u − ½); row 0 is +y.
class Environment {
  public:
    /// The largest finite half float, which replaces infinity: writers clamp the sun to it, too.
    static constexpr float largest_half = 65504;

    /// The image is RGB or grey, 8-bit sRGB or linear float. Negative values and NaN become 0;
    /// infinite ones, and those too large to be added up, become `largest_half`. `rotation` is
    /// about +y, in radians; radiances are multiplied by `brightness`.
    Environment(const Image& image, float rotation, float brightness = 1);

    /// The number of texels with a channel that became `largest_half`.
    size_t overflowed_texels() const { return overflowed_texels_; }

    using Sample = EnvironmentSample;

    /// Radiance from unit directions, bilinear, and, unless `pdfs` is empty, the pdfs with which
    /// sample() picks them. In batches, because most of the time is spent waiting for memory.
    void look_up(std::span<const Vec3> directions, std::span<Vec3> radiance,
                 std::span<float> pdfs) const;
    Vec3 radiance(const Vec3& d) const;
    /// The mean over the sphere of directions, from 1024 of them.
    Vec3 mean_radiance() const;
    /// The integral over the sphere of directions. Its luminance is that of a sample's radiance
    /// over its pdf, which is the same for all samples.
    Vec3 integral() const;
    /// A copy with so many columns, whose texels are what `change` makes of the y of their
    /// direction and their radiance: interpolated, or the mean of what becomes one. `change` is
    /// called from several threads.
    Environment changed(const std::function<Vec3(float y, const Vec3& radiance)>& change,
                        int columns) const;
    int columns() const { return tables_.width; }
    float pdf(const Vec3& d) const;  ///< per solid angle

    /// Samples directions from points in [0,1)², with a pdf in proportion to the luminance of the
    /// bilinear image.
    void sample(std::span<const float> u, std::span<const float> v,
                std::span<Sample> samples) const;
    Sample sample(Vec2 u) const;

    /// A copy in which a point is a spot of this radius, in radians: a normal distribution of half
    /// that as its standard deviation, over directions. It has no finer detail than that.
    Environment blurred(float radius) const;

  private:
    Environment() = default;
    void build_tables();
    bool is_black() const;

    EnvironmentTables tables_;
    size_t overflowed_texels_ = 0;
};

}  // namespace sightline
