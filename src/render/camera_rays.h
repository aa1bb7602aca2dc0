#pragma once
#include "core/ray.h"
#include "render/settings.h"

#include <span>

namespace sightline {

/// Turns positions on the picture into rays.
class CameraRays {
  public:
    /// `focus` as in the settings, 0 replaced by the distance to the centre of `bounds`.
    CameraRays(const RenderSettings& settings, const Box3& bounds);

    /// The ray through raster position (pixels, y down); `lens` in [0,1)² where the aperture is
    /// open. The direction is of unit length.
    Ray ray(float x, float y, Vec2 lens) const;

    /// The same for many raster positions, where the aperture is closed.
    void rays(std::span<const float> x, std::span<const float> y, std::span<Ray> rays) const;

    /// Width of a pixel at distance 0 and its growth per unit of distance.
    float pixel_width() const { return pixel_width_; }
    float pixel_spread() const { return pixel_spread_; }

    bool has_lens() const { return lens_radius_ > 0; }

    Mat4 world_to_camera() const { return world_to_camera_; }
    /// To normalised device coordinates in [0,1]², y up, as the EXR attribute worldToNDC.
    Mat4 world_to_ndc() const;

  private:
    bool orthographic_;
    Mat4 to_world_, world_to_camera_;
    float width_, height_;
    float half_x_, half_y_;  // half the view at distance 1, or in world units (orthographic)
    float near_, far_;
    float lens_radius_, focus_;
    float pixel_width_ = 0, pixel_spread_ = 0;
};

}  // namespace sightline
