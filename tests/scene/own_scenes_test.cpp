// The scenes in scenes/ load without warnings, with their SIGHTLINE extensions.
#include "core/error.h"
#include "scene/gltf/load.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace sightline {
namespace {

const std::string scenes = SIGHTLINE_SOURCE_DIR "/scenes/";

TEST(OwnScenes, AreImportedWithoutAWarning) {
    for (const auto& entry : std::filesystem::directory_iterator(scenes)) {
        if (entry.path().extension() != ".gltf") continue;
        const Scene scene = load_gltf(entry.path());
        EXPECT_TRUE(scene.warnings.empty()) << entry.path() << ": " << scene.warnings[0];
        EXPECT_EQ(scene.cameras.size(), 1u) << entry.path();
        EXPECT_FALSE(scene.instances.empty()) << entry.path();
    }
}

TEST(OwnScenes, WhittedHasTwoSpheresOneQuadAndABackground) {
    const Scene scene = load_gltf(scenes + "whitted.gltf");
    ASSERT_EQ(scene.shapes.size(), 2u);
    ASSERT_EQ(scene.meshes.size(), 1u);
    const Shape& glass = scene.shapes[0];
    EXPECT_EQ(glass.name, "glass");
    EXPECT_EQ(glass.kind, ShapeKind::sphere);
    EXPECT_FLOAT_EQ(glass.radius, 1.15f);
    EXPECT_EQ(glass.to_object[3][1], 2.35);
    EXPECT_EQ(scene.materials[glass.material].transmission_factor, 1);
    EXPECT_EQ(scene.materials[scene.shapes[1].material].metallic_factor, 1);
    ASSERT_TRUE(scene.background);
    EXPECT_EQ(*scene.background, Vec3(0.2f, 0.45f, 0.8f));
    EXPECT_TRUE(scene.bounds.intersects(Vec3(1.35f, 2.69f, -0.6f)));
}

/// The error message of loading a document strictly; empty if it loads.
std::string complaint_about(const std::string& json) {
    const std::string path = test_folder() / "a.gltf";
    std::ofstream(path) << json;
    try {
        LoadOptions options;
        options.strict = true;
        load_gltf(path, options);
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

TEST(OwnScenes, ABadBackgroundOrShapeIsAnErrorWithItsPlace) {
    const std::string head = R"({"asset": {"version": "2.0"}, )";
    EXPECT_NE(complaint_about(head + R"("scenes": [{"extensions": {"SIGHTLINE_background":
                  {"color": [1, 2]}}}]})")
                  .find("scenes[0].extensions.SIGHTLINE_background.color"),
              std::string::npos);
    const std::string shapes = R"("extensions": {"KHR_implicit_shapes": {"shapes": [
        {"type": "sphere", "sphere": {"radius": -1}}]}}, "scenes": [{"nodes": [0]}], )";
    EXPECT_NE(complaint_about(head + shapes +
                              R"("nodes": [{"extensions": {"SIGHTLINE_implicit_shapes":
                                  {"shape": 0}}}]})")
                  .find("extensions.KHR_implicit_shapes.shapes[0].sphere.radius: is not above 0"),
              std::string::npos);
    EXPECT_NE(complaint_about(head + shapes +
                              R"("nodes": [{"extensions": {"SIGHTLINE_implicit_shapes":
                                  {"shape": 7}}}]})")
                  .find("nodes[0].extensions.SIGHTLINE_implicit_shapes.shape"),
              std::string::npos);
}

}  // namespace
}  // namespace sightline
