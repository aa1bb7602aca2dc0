#include "render/camera_rays.h"
#include "scene/camera_fit.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

RenderSettings job_with(const Camera& camera, int width, int height) {
    RenderSettings settings;
    settings.width = width;
    settings.height = height;
    settings.camera = camera;
    return settings;
}

TEST(CameraRays, TheCentreOfThePictureLooksAlongTheAxis) {
    const Camera camera = look_at({1, 2, 3}, {1, 2, -5}, {0, 1, 0}, pi / 2);
    const CameraRays rays(job_with(camera, 200, 100), Box3());
    const Ray ray = rays.ray(100, 50, {});
    EXPECT_EQ(ray.origin, Vec3(1, 2, 3));
    EXPECT_LT((ray.direction - Vec3(0, 0, -1)).length(), 1e-6f);
}

TEST(CameraRays, TheFieldOfViewIsVerticalAndYPointsDownThePicture) {
    const Camera camera = look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, pi / 2);
    const CameraRays rays(job_with(camera, 200, 100), Box3());
    const Vec3 top = rays.ray(100, 0, {}).direction;
    EXPECT_NEAR(top.y / -top.z, 1, 1e-6f);
    const Vec3 right = rays.ray(200, 50, {}).direction;
    EXPECT_NEAR(right.x / -right.z, 2, 1e-6f);
}

TEST(CameraRays, TheViewOfAFilesCameraFitsInANarrowerPicture) {
    Camera camera = look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, pi / 2);
    camera.aspect = 2;
    const CameraRays rays(job_with(camera, 100, 100), Box3());
    const Vec3 right = rays.ray(100, 50, {}).direction;
    EXPECT_NEAR(right.x / -right.z, 2, 1e-5f);
}

TEST(CameraRays, AFittedCamerasFieldOfViewIsVerticalInAPictureOfAnyShape) {
    const Box3 bounds({-1, -1, -1}, {1, 1, 1});
    const Camera camera = fit_camera(bounds);
    for (const int width : {50, 100, 300}) {
        const CameraRays rays(job_with(camera, width, 100), bounds);
        const auto towards = [&](float y) {
            return normalize(rays.ray(0.5f * static_cast<float>(width), y, {}).direction);
        };
        EXPECT_NEAR(std::acos(dot(towards(0), towards(100))), pi / 4, 1e-5f);
    }
}

TEST(CameraRays, BatchesEqualSingleRays) {
    Camera camera;
    camera.to_world = Mat4().setAxisAngle(Vec3(1, 2, 3), 0.7f);
    camera.to_world[3][0] = 5;
    camera.znear = 0.25f;
    camera.zfar = 100;
    for (const bool orthographic : {false, true}) {
        camera.orthographic = orthographic;
        const CameraRays rays(job_with(camera, 333, 222), Box3());
        std::vector<float> x, y;
        for (int i = 0; i < 131; ++i) {
            x.push_back(static_cast<float>(i) * 2.531f);
            y.push_back(222 - static_cast<float>(i) * 1.7f);
        }
        std::vector<Ray> all(x.size());
        rays.rays(x, y, all);
        for (size_t i = 0; i < x.size(); ++i) {
            const Ray one = rays.ray(x[i], y[i], {});
            ASSERT_EQ(all[i].origin, one.origin) << i;
            ASSERT_EQ(all[i].direction, one.direction) << i;
            ASSERT_EQ(all[i].tnear, one.tnear) << i;
            ASSERT_EQ(all[i].tfar, one.tfar) << i;
        }
    }
}

TEST(CameraRays, OrthographicRaysAreParallelAndSpanTheMagnification) {
    Camera camera;
    camera.orthographic = true;
    camera.xmag = 2;
    camera.ymag = 1;
    const CameraRays rays(job_with(camera, 200, 100), Box3());
    EXPECT_EQ(rays.ray(0, 0, {}).origin, Vec3(-2, 1, 0));
    EXPECT_EQ(rays.ray(0, 0, {}).direction, Vec3(0, 0, -1));
    EXPECT_EQ(rays.ray(200, 100, {}).origin, Vec3(2, -1, 0));
}

TEST(CameraRays, RaysFromEveryLensPointMeetInThePlaneOfFocus) {
    const Camera camera = look_at({0, 0, 10}, {0, 0, 0}, {0, 1, 0}, pi / 4);
    RenderSettings settings = job_with(camera, 100, 100);
    settings.aperture = 1;
    settings.focus = 4;
    const CameraRays rays(settings, Box3());
    const Vec3 expected(0, 0, 6);
    for (const Vec2& lens : {Vec2(0.1f, 0.2f), Vec2(0.9f, 0.5f), Vec2(0.5f, 0.99f)}) {
        const Ray ray = rays.ray(50, 50, lens);
        const float t = (6 - ray.origin.z) / ray.direction.z;
        EXPECT_LT((ray.origin + ray.direction * t - expected).length(), 1e-5f);
    }
}

TEST(CameraRays, NormalisedDeviceCoordinatesMatchTheRaster) {
    const Camera camera = look_at({3, 2, 5}, {0, 0, 0}, {0, 1, 0}, pi / 5);
    const CameraRays rays(job_with(camera, 320, 200), Box3());
    const Ray ray = rays.ray(80, 150, {});
    const Vec3 point = ray.origin + ray.direction * 7.0f;
    const Mat4 m = rays.world_to_ndc();
    const Vec4 ndc = Vec4(point.x, point.y, point.z, 1) * m;
    EXPECT_NEAR(ndc.x / ndc.w, 80.0f / 320, 1e-5f);
    EXPECT_NEAR(ndc.y / ndc.w, 1 - 150.0f / 200, 1e-5f);
}

TEST(CameraRays, ClippingPlanesBecomeDistancesAlongTheRay) {
    Camera camera = look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, pi / 2);
    camera.znear = 1;
    camera.zfar = 10;
    const CameraRays rays(job_with(camera, 100, 100), Box3());
    const Ray corner = rays.ray(100, 50, {});
    EXPECT_NEAR(corner.tnear, std::sqrt(2.0f), 1e-5f);
    EXPECT_NEAR(corner.tfar, 10 * std::sqrt(2.0f), 1e-4f);
}

}  // namespace
}  // namespace sightline
