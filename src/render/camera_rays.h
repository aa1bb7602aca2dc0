#pragma once
#include "core/ray.h"
#include "render/settings.h"

#include <span>

namespace sightline {

/// Camera rays through positions on the picture.
class CameraRays {
  public:
    /// If settings.focus is 0, the lens focuses on the centre of `bounds`, the scene's.
    CameraRays(const RenderSettings& settings, const Box3& bounds);

    /// The ray through a raster position (pixels, y down); `lens` in [0,1)², ignored without a
    /// lens. The direction has unit length.
    Ray ray(float x, float y, Vec2 lens) const;

    /// The same for many raster positions, without a lens.
    void rays(std::span<const float> x, std::span<const float> y, std::span<Ray> rays) const;

    /// The ray cone of a pixel: its width at distance 0, and its growth per unit of distance.
    float pixel_width() const { return pixel_width_; }
    float pixel_spread() const { return pixel_spread_; }

    bool has_lens() const { return lens_radius_ > 0; }

    /// Half of the picture's width and height: at distance 1 from the camera or, if it is
    /// orthographic, in world units.
    Vec2 half_size() const { return {half_x_, half_y_}; }

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
