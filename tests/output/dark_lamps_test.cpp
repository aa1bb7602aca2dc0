// When the studio joins a file's own lamps.
#include "output/environment_cache.h"
#include "support/pictures.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

/// A ball of radius 1 about the origin, whose bounds have a sphere of radius sqrt(3), and a lamp.
Scene lit_by(const Light& lamp) {
    SceneBuilder builder;
    draw(builder, ball({0, 0, 0}, 1), matte({1, 1, 1}));
    builder.add_light(lamp);
    return builder.finish();
}

TEST(DarkLamps, TheBrightnessIsThatOfAWhiteSurfaceWhereALampComesNearest) {
    Light lamp = point_light({0, 0, 2 + std::sqrt(3.0f)}, 8);
    EXPECT_NEAR(lamp_brightness(lit_by(lamp)), 8 / 4.0 / M_PI, 1e-3);
    lamp.range = 1;
    EXPECT_EQ(lamp_brightness(lit_by(lamp)), 0);
    lamp.range = 100;
    lamp.kind = LightKind::spot;
    lamp.direction = {0, 0, 1};
    EXPECT_EQ(lamp_brightness(lit_by(lamp)), 0);
    lamp.direction = {0, 0, -1};
    EXPECT_NEAR(lamp_brightness(lit_by(lamp)), 8 / 4.0 / M_PI, 1e-3);
    lamp.kind = LightKind::directional;
    EXPECT_NEAR(lamp_brightness(lit_by(lamp)), 8 / M_PI, 1e-6);
}

TEST(DarkLamps, AreJoinedByTheStudioUnlessThereIsABackgroundOrAWish) {
    Light sun;
    sun.kind = LightKind::directional;
    sun.intensity = static_cast<float>(dark_lamps * M_PI * 0.9);
    Scene scene = lit_by(sun);
    EXPECT_EQ(choose_environment({}, scene), "studio");
    LightOptions none;
    none.env = "none";
    EXPECT_EQ(choose_environment(none, scene), "none");
    scene.lights[0].intensity *= 1.2f;
    EXPECT_EQ(choose_environment({}, scene), "none");
    scene.lights.clear();
    scene.background = Vec3(0, 0, 1);
    EXPECT_EQ(choose_environment({}, scene), "none");
}

}  // namespace
}  // namespace sightline
