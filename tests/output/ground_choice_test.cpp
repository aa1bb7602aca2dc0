// Where the ground of a picture lies, and which grounds a command cannot have.
#include "output/ground_choice.h"

#include "output/render_asset.h"
#include "support/gltf.h"
#include "support/pictures.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

RenderCommand shadow_command() {
    RenderCommand command;
    command.ground.kind = GroundKind::shadow;
    return command;
}

TEST(ChooseGround, LiesBelowTheLowestPointByAPartOfTheSceneThatNoPictureShows) {
    const Scene scene = scene_of(ball({0, 5, 0}, 2), matte({1, 1, 1}));
    const GroundSettings ground = choose_ground(shadow_command(), scene, Vec3(0));
    const double diagonal = double(scene.bounds.size().length());
    EXPECT_EQ(ground.kind, GroundKind::shadow);
    EXPECT_LT(ground.height, 3);
    EXPECT_NEAR(ground.height, 3 - diagonal * ground_gap, 1e-5);
}

TEST(ChooseGround, DoesNotCountWhatCannotBeSeen) {
    Material invisible = matte({1, 1, 1});
    invisible.alpha_mode = AlphaMode::blend;
    invisible.base_color_factor.w = 0;
    SceneBuilder builder;
    draw(builder, ball({0, 5, 0}, 2), matte({1, 1, 1}));
    draw(builder, ball({0, -5, 0}, 2), invisible);
    EXPECT_NEAR(choose_ground(shadow_command(), builder.finish(), Vec3(0)).height, 3, 0.01);
}

TEST(ChooseGround, LiesWhereItIsAskedFor) {
    const Scene scene = scene_of(ball({0, 5, 0}, 2), matte({1, 1, 1}));
    RenderCommand command = shadow_command();
    command.ground.height = 4.5;
    EXPECT_NEAR(choose_ground(command, scene, Vec3(0)).height, 4.5, 0.001);
}

TEST(ChooseGround, IsGivenInWorldUnitsForAFarScene) {
    Scene scene = scene_of(ball({0, 5, 0}, 2), matte({1, 1, 1}));
    scene.frame.origin = Vec3d(1e6, 2e6, 0);
    RenderCommand command = shadow_command();
    command.ground.height = 2e6 + 4;
    EXPECT_NEAR(choose_ground(command, scene, Vec3(0)).height, 4, 0.001);
}

TEST(ChooseGround, IsNoneBelowNothing) {
    EXPECT_EQ(choose_ground(shadow_command(), empty_scene(), Vec3(0)).kind, GroundKind::nothing);
}

TEST(ChooseGround, HasTheBackgroundsColourOnlyAsACyclorama) {
    const Scene scene = scene_of(ball({0, 5, 0}, 2), matte({1, 1, 1}));
    RenderCommand command = shadow_command();
    command.ground.color = {1, 0, 0};
    command.ground.kind = GroundKind::cyclorama;
    EXPECT_EQ(choose_ground(command, scene, Vec3(0, 1, 0)).color, Vec3(0, 1, 0));
    command.ground.kind = GroundKind::matte;
    EXPECT_EQ(choose_ground(command, scene, Vec3(0, 1, 0)).color, Vec3(1, 0, 0));
    EXPECT_EQ(choose_ground(command, scene, Vec3(0, 1, 0)).mirror, 0);
}

TEST(ChooseGround, LiesBelowAllFramesOfAnAnimation) {
    GltfBuilder file;
    file.triangle();
    file.json["scenes"] = {{{"nodes", {0}}}};
    const size_t times = file.floats({0, 0.5f, 1}, "SCALAR");
    file.json["accessors"][times].update({{"min", {0}}, {"max", {1}}});
    const size_t places = file.floats({0, 0, 0, 0, -7, 0, 0, 2, 0}, "VEC3");
    file.add(
        "animations",
        {{"samplers", {{{"input", times}, {"output", places}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}});
    RenderCommand command = shadow_command();
    command.asset = file.save();
    const float rest = choose_ground(command, load_gltf(command.asset), Vec3(0)).height;
    command.view.frame_for = FrameRange{0, 4, 4};
    for (const float time : {0.0f, 0.5f, 1.0f}) {
        command.load.time = time;
        const Scene scene = load_gltf(command.asset, command.load);
        EXPECT_NEAR(choose_ground(command, scene, Vec3(0)).height, rest - 7, 0.001) << time;
    }
}

TEST(GroundProblem, NamesWhatDoesNotGoTogether) {
    EXPECT_EQ(ground_problem({}), "");
    EXPECT_EQ(ground_problem(shadow_command()), "");
    RenderCommand command;
    command.ground.height = 1;
    EXPECT_NE(ground_problem(command).find("--ground-height"), std::string::npos);
    command = {};
    command.ground.mirror = 0.5f;
    EXPECT_NE(ground_problem(command).find("--ground-mirror"), std::string::npos);
    command = shadow_command();
    command.ground.kind = GroundKind::cyclorama;
    EXPECT_EQ(ground_problem(command), "");
    for (const Background background : {Background::transparent, Background::environment}) {
        command.light.background = background;
        EXPECT_NE(ground_problem(command).find("--background"), std::string::npos);
    }
}

}  // namespace
}  // namespace sightline
