#include "scene/camera_fit.h"
#include "output/render_asset.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

Vec3 view_of(const Camera& camera) {
    return {-camera.to_world[2][0], -camera.to_world[2][1], -camera.to_world[2][2]};
}

TEST(CameraFit, ANamedViewLooksAtTheCentreFromTheFittedDistance) {
    const Box3 bounds({1, 2, 3}, {3, 4, 5});
    const std::pair<const char*, Vec3> sides[] = {{"front", {0, 0, 1}}, {"back", {0, 0, -1}},
                                                  {"left", {-1, 0, 0}}, {"right", {1, 0, 0}},
                                                  {"top", {0, 1, 0}},   {"bottom", {0, -1, 0}}};
    for (const auto& [name, direction] : sides) {
        const Camera camera = fit_camera(bounds, *find_view(name));
        EXPECT_LT((view_of(camera) + direction).length(), 1e-6f) << name;
        const Vec3 position(camera.to_world[3][0], camera.to_world[3][1], camera.to_world[3][2]);
        const float distance = std::sqrt(3.0f) / std::sin(pi / 8);
        EXPECT_LT((position - Vec3(2, 3, 4) - direction * distance).length(), 1e-5f) << name;
    }
}

TEST(CameraFit, ARequestedFieldOfViewIsUsed) {
    Scene scene;
    scene.cameras.emplace_back().aspect = 2;
    RenderCommand command;
    EXPECT_EQ(complete_settings(command, scene).camera.aspect, 2);
    command.view.fov = 30.0f;
    EXPECT_EQ(complete_settings(command, scene).camera.aspect, 0);
    EXPECT_FLOAT_EQ(complete_settings(command, scene).camera.yfov, pi / 6);
}

}  // namespace
}  // namespace sightline
