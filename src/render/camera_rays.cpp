#include "render/camera_rays.h"

#include "core/sampler.h"
#include "core/vectorise.h"

#include <cassert>

namespace sightline {
namespace {

struct PerspectiveCamera {
    float width, height, half_x, half_y, near, far;
    Mat4 to_world;
};

constexpr size_t batch = 64;

/// Rays as structure of arrays.
struct RayBatch {
    float x[batch], y[batch], z[batch], tnear[batch], tfar[batch];
};

// The same operations as CameraRays::ray.
[[gnu::always_inline]] inline void generate_rays(const PerspectiveCamera& camera,
                                                 const float* __restrict raster_x,
                                                 const float* __restrict raster_y, RayBatch& rays) {
    const PerspectiveCamera c = camera;  // a copy, since the stores below may alias
    const Mat4& m = c.to_world;
    for (size_t i = 0; i < batch; ++i) {
        const float vx = (2 * raster_x[i] / c.width - 1) * c.half_x;
        const float vy = (1 - 2 * raster_y[i] / c.height) * c.half_y;
        const float vz = -1;
        const float depth_per_t = 1 / std::sqrt(vx * vx + vy * vy + vz * vz);
        const float x = vx * m[0][0] + vy * m[1][0] + vz * m[2][0];
        const float y = vx * m[0][1] + vy * m[1][1] + vz * m[2][1];
        const float z = vx * m[0][2] + vy * m[1][2] + vz * m[2][2];
        const float length2 = x * x + y * y + z * z;
        const float scale = length2 > 0 ? 1 / std::sqrt(length2) : 1;
        rays.x[i] = x * scale;
        rays.y[i] = y * scale;
        rays.z[i] = z * scale;
        rays.tnear[i] = c.near / depth_per_t;
        rays.tfar[i] = c.far / depth_per_t;
    }
}

}  // namespace

CameraRays::CameraRays(const RenderSettings& settings, const Box3& bounds)
    : orthographic_(settings.camera.orthographic),
      to_world_(settings.camera.to_world),
      world_to_camera_(settings.camera.to_world.inverse()),
      width_(static_cast<float>(settings.width)),
      height_(static_cast<float>(settings.height)),
      near_(settings.camera.znear),
      far_(settings.camera.zfar),
      lens_radius_(settings.aperture / 2),
      focus_(settings.focus) {
    const float picture_aspect = width_ / height_;
    // If the aspect ratios differ, the whole view of the camera fits in the picture.
    if (orthographic_) {
        half_x_ = settings.camera.xmag;
        half_y_ = settings.camera.ymag;
    } else {
        half_y_ = std::tan(settings.camera.yfov / 2);
        half_x_ = half_y_ * (settings.camera.aspect > 0 ? settings.camera.aspect : picture_aspect);
    }
    if (half_x_ / half_y_ < picture_aspect) {
        half_x_ = half_y_ * picture_aspect;
    } else {
        half_y_ = half_x_ / picture_aspect;
    }
    (orthographic_ ? pixel_width_ : pixel_spread_) = 2 * half_y_ / height_;
    if (focus_ <= 0) {
        const Vec3 centre = bounds.isEmpty() ? Vec3(0, 0, -1) : bounds.center();
        const float radius = bounds.isEmpty() ? 1 : bounds.size().length() / 2;
        focus_ = std::fmax(-transform_point(centre, world_to_camera_).z,
                           1e-3f * std::fmin(radius, 1.0f));
    }
}

Ray CameraRays::ray(float x, float y, Vec2 lens) const {
    const float view_x = (2 * x / width_ - 1) * half_x_;
    const float view_y = (1 - 2 * y / height_) * half_y_;
    Vec3 origin = orthographic_ ? Vec3(view_x, view_y, 0) : Vec3(0, 0, 0);
    Vec3 direction = orthographic_ ? Vec3(0, 0, -1) : Vec3(view_x, view_y, -1);
    const float depth_per_t = 1 / std::sqrt(dot(direction, direction));
    if (lens_radius_ > 0) {
        const Vec3 in_focus = origin + direction * focus_;
        const Vec2 offset = sample_disc(lens) * lens_radius_;
        origin += Vec3(offset.x, offset.y, 0);
        direction = in_focus - origin;
    }
    Ray ray;
    ray.origin = transform_point(origin, to_world_);
    ray.direction = normalize(transform_vector(direction, to_world_));
    ray.tnear = near_ / depth_per_t;
    ray.tfar = far_ / depth_per_t;
    return ray;
}

void CameraRays::rays(std::span<const float> x, std::span<const float> y,
                      std::span<Ray> rays) const {
    assert(!has_lens() && x.size() == y.size() && x.size() == rays.size());
    if (orthographic_) {
        for (size_t i = 0; i < rays.size(); ++i) rays[i] = ray(x[i], y[i], {});
        return;
    }
    static const auto best_generate_rays = best_version<generate_rays, const PerspectiveCamera&,
                                                        const float*, const float*, RayBatch&>();
    const PerspectiveCamera camera = {width_, height_, half_x_, half_y_, near_, far_, to_world_};
    const Vec3 origin = transform_point(Vec3(0, 0, 0), to_world_);
    RayBatch results;
    for (size_t begin = 0; begin < rays.size(); begin += batch) {
        const size_t count = std::min(batch, rays.size() - begin);
        float raster_x[batch] = {}, raster_y[batch] = {};
        std::copy_n(&x[begin], count, raster_x);
        std::copy_n(&y[begin], count, raster_y);
        best_generate_rays(camera, raster_x, raster_y, results);
        for (size_t i = 0; i < count; ++i)
            rays[begin + i] = {origin, results.tnear[i],
                               Vec3(results.x[i], results.y[i], results.z[i]), results.tfar[i]};
    }
}

Mat4 CameraRays::world_to_ndc() const {
    Mat4 projection;
    projection[0][0] = 0.5f / half_x_;
    projection[1][1] = 0.5f / half_y_;
    if (orthographic_) {
        projection[3][0] = projection[3][1] = 0.5f;
    } else {
        projection[2][0] = projection[2][1] = -0.5f;  // the centre lies at 0.5 after dividing by w
        projection[2][3] = -1;
        projection[3][3] = 0;
    }
    return world_to_camera_ * projection;
}

}  // namespace sightline
