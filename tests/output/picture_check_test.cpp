#include "output/picture_check.h"

#include "output/render_asset.h"
#include "support/gltf.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

/// A command for the triangle of a file, 16 × 16 pixels, seen from z = 3, in the studio.
RenderCommand command_for(const GltfBuilder& file) {
    RenderCommand command;
    command.asset = file.save();
    command.view.look_from = Vec3d(0.3, 0.3, 3);
    command.view.look_at = Vec3d(0.3, 0.3, 0);
    command.light.background = Background::transparent;
    command.settings.width = command.settings.height = 16;
    command.settings.samples = 1;
    command.run.threads = 1;
    command.output.pictures = {(test_folder() / "picture.exr").string()};
    return command;
}

/// A triangle with this material.
GltfBuilder triangle(const nlohmann::json& material = {{"doubleSided", true}}) {
    GltfBuilder file;
    file.triangle();
    file.json["materials"] = nlohmann::json::array({material});
    file.json["meshes"][0]["primitives"][0]["material"] = 0;
    return file;
}

/// The picture has this content, for this reason, which the last warning gives.
void expect_blank(const RenderCommand& command, PictureContent content, const std::string& reason) {
    const AssetResult result = render_asset(command);
    EXPECT_EQ(result.content, content);
    ASSERT_FALSE(result.warnings.empty());
    EXPECT_EQ(result.warnings.back(),
              std::string("the picture is ") + to_string(content) + ": " + reason);
}

TEST(PictureCheck, AVisibleAssetIsSomethingWithoutAWord) {
    for (const Background background : {Background::transparent, Background::environment}) {
        RenderCommand command = command_for(triangle());
        command.light.background = background;
        const AssetResult result = render_asset(command);
        EXPECT_EQ(result.content, PictureContent::something);
        EXPECT_TRUE(result.warnings.empty());
    }
}

// The environment in the background makes it no less empty.
TEST(PictureCheck, WhatTheCameraMissesIsEmptyForAReason) {
    RenderCommand command = command_for(triangle());
    command.light.background = Background::environment;
    command.view.look_at = Vec3d(0.3, 0.3, 6);
    expect_blank(command, PictureContent::empty, "the asset lies behind the camera");
    command.view.look_at = Vec3d(30, 0.3, 0);
    expect_blank(command, PictureContent::empty, "the camera looks past the asset");
    command.view.look_from = Vec3d(3e5, 0.3, 3);
    command.view.look_at = Vec3d(0.5, 0.5, 0);
    expect_blank(command, PictureContent::empty, "the asset is smaller than a pixel");
    GltfBuilder nothing;
    expect_blank(command_for(nothing), PictureContent::empty, "the asset has nothing to draw");
}

TEST(PictureCheck, ALensThatClipsTheAssetIsNamed) {
    for (const bool near : {true, false}) {
        GltfBuilder file = triangle();
        file.json["cameras"] = {
            {{"type", "perspective"},
             {"perspective",
              {{"yfov", 1}, {"znear", near ? 5.0 : 0.01}, {"zfar", near ? 9.0 : 1.0}}}}};
        file.add("nodes", {{"camera", 0}, {"translation", {0.3, 0.3, 3}}});
        RenderCommand command = command_for(file);
        command.view = {};
        expect_blank(command, PictureContent::empty,
                     near ? "the asset lies before the camera's znear"
                          : "the asset lies beyond the camera's zfar");
    }
}

TEST(PictureCheck, WhatCannotBeSeenIsEmpty) {
    const std::string reason =
        "all that the camera meets is fully transparent, or culled since it is seen from behind";
    expect_blank(
        command_for(triangle({{"alphaMode", "BLEND"},
                              {"doubleSided", true},
                              {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0}}}}})),
        PictureContent::empty, reason);
    RenderCommand command = command_for(triangle({{"doubleSided", false}}));
    command.view.look_from = Vec3d(0.3, 0.3, -3);
    expect_blank(command, PictureContent::empty, reason);
}

TEST(PictureCheck, WhatIsNotLitIsBlack) {
    RenderCommand command = command_for(triangle());
    command.light.env = "none";
    expect_blank(command, PictureContent::black,
                 "there is no light: the asset has none, and the environment is none");
    GltfBuilder lit = triangle();
    lit.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "point"}, {"range", 0.5}, {"intensity", 9}}};
    lit.add("nodes", {{"translation", {0, 0, 2}},
                      {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    command = command_for(lit);
    command.light.env = "none";  // otherwise the studio joins a lamp that leaves all dark
    expect_blank(command, PictureContent::black,
                 "no light reaches what the camera sees, or it reflects none");
}

}  // namespace
}  // namespace sightline
