// Limits on what a file may request, and values outside the range that can be rendered.
#include "scene/camera_fit.h"
#include "support/gltf.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sightline {
namespace {

using nlohmann::json;

TEST(GltfLimits, NamesCannotBreakTheLinesOfMessages) {
    const std::string evil = "a\nb\x1b[2J\r\u0085";
    GltfBuilder used;
    used.triangle();
    used.json["extensionsUsed"] = {evil};
    const Scene scene = load_gltf(used.save());
    ASSERT_EQ(scene.warnings.size(), 1u);
    const std::string expected = "a\\nb\\x1b[2J\\x0d\\xc2\\x85 is not supported";
    EXPECT_NE(scene.warnings[0].find(expected), std::string::npos) << scene.warnings[0];
    used.json["extensionsRequired"] = {evil};
    EXPECT_TRUE(fails(used.save(), expected));
    GltfBuilder missing;
    missing.triangle();
    missing.json["buffers"] = {{{"byteLength", 36}, {"uri", "a\nb.bin"}}};
    EXPECT_TRUE(fails(write_file(test_folder() / "test.gltf", missing.json.dump()),
                      "buffers[0].uri: 'a\\nb.bin' is not an existing file"));
}

TEST(GltfLimits, AHundredThousandWarningsAreTruncatedAndCounted) {
    GltfBuilder file;
    file.triangle();
    json& materials = file.json["materials"] = json::array();
    for (int i = 0; i < 100000; ++i)
        materials.push_back({{"pbrMetallicRoughness", {{"roughnessFactor", 2}}}});
    const Scene scene = load_gltf(file.save());
    ASSERT_EQ(scene.warnings.size(), 201u);
    EXPECT_EQ(scene.warnings.back(), "… and 99800 more");
    EXPECT_NE(scene.warnings[0], scene.warnings[1]);
}

TEST(GltfLimits, ManyPrimitivesOfTheSameBytesExhaustTheBudget) {
    GltfBuilder file;
    const size_t positions = file.floats(std::vector<float>(3000, 1), "VEC3");
    json primitives = json::array();
    for (int i = 0; i < 10; ++i) primitives.push_back({{"attributes", {{"POSITION", positions}}}});
    const size_t mesh = file.add("meshes", {{"primitives", primitives}});
    file.add("nodes", {{"mesh", mesh}});
    LoadOptions options;
    options.max_accessor_values = 30000;
    const std::string path = file.save();
    EXPECT_EQ(load_gltf(path, options).instances.size(), 1u);
    options.max_accessor_values = 29999;
    EXPECT_TRUE(fails(path, "accessors[0]: the count of numbers read", options));
}

TEST(GltfLimits, InstancesAreChargedToTheBudget) {
    GltfBuilder file;
    file.triangle();
    file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", file.floats(std::vector<float>(300, 1), "VEC3")}};
    LoadOptions options;
    options.max_accessor_values = 100000;
    const std::string path = file.save();
    EXPECT_EQ(load_gltf(path, options).instances.size(), 100u);
    options.max_accessor_values = 1000;
    EXPECT_TRUE(fails(path, "nodes[0].extensions.EXT_mesh_gpu_instancing", options));
}

TEST(GltfLimits, ManyPrimitivesWithoutDataExhaustTheBudget) {
    GltfBuilder file;
    file.triangle();
    const size_t zeros =
        file.add("accessors", {{"componentType", 5126}, {"type", "VEC3"}, {"count", 1 << 22}});
    json primitives = json::array();
    for (int i = 0; i < 100; ++i)
        primitives.push_back(
            {{"attributes", {{"POSITION", zeros}}}, {"indices", file.indices({0, 1, 2})}});
    file.json["meshes"].push_back({{"primitives", primitives}});
    file.add("nodes", {{"mesh", 1}});
    EXPECT_TRUE(
        fails(file.save(), "accessors[1]: too many elements of accessors without data are read"));
}

Scene load_at_scale(const json& scale, int places) {
    GltfBuilder file;
    file.mesh_node({{"attributes",
                     {{"POSITION", file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1e30f, 0, 0}, "VEC3")}}},
                    {"indices", file.indices({0, 1, 2, 0, 1, 3})}});
    file.json["nodes"][0]["scale"] = scale;
    for (int i = 1; i < places; ++i) file.add("nodes", {{"mesh", 0}});
    return load_gltf(file.save());
}

TEST(GltfLimits, TrianglesOutOfRangeAreDroppedFromMeshAndBounds) {
    const Scene baked = load_at_scale({1e10, 1, 1}, 1);  // 1e40 is no float
    ASSERT_EQ(baked.meshes.at(0).triangles.size(), 1u);
    EXPECT_EQ(baked.meshes[0].positions.size(), 3u);
    EXPECT_EQ(Vec3(baked.frame.leave(Vec3d(baked.bounds.max))), Vec3(1e10f, 1, 0));
    ASSERT_EQ(baked.warnings.size(), 1u);
    EXPECT_NE(baked.warnings[0].find("meshes[0].primitives[0]: 1 triangles"), std::string::npos);
    const Scene instanced = load_at_scale({2, 1, 1}, 2);
    EXPECT_EQ(instanced.bounds.max, Vec3(2, 1, 0));
    const Camera camera = fit_camera(Box3(Vec3(-1e18f), Vec3(1e18f)));
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(std::isfinite(camera.to_world[3][i]));
}

TEST(GltfLimits, LargeObjectSpaceCoordinatesAreKeptIfInRangeInWorldSpace) {
    const Scene scene = load_at_scale({1e-30, 1, 1}, 1);
    EXPECT_EQ(scene.meshes.at(0).triangles.size(), 2u);
    EXPECT_FLOAT_EQ(scene.bounds.max.x, 1);
    EXPECT_TRUE(scene.warnings.empty());
}

Light load_light(const json& light, size_t warnings) {
    GltfBuilder file;
    file.json["extensions"]["KHR_lights_punctual"]["lights"] = json::array({light});
    file.add("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    const Scene scene = load_gltf(file.save());
    EXPECT_EQ(scene.warnings.size(), warnings);
    for (const std::string& line : scene.warnings)
        EXPECT_TRUE(line.starts_with("extensions.KHR_lights_punctual.lights[0].")) << line;
    return scene.lights.at(0);
}

TEST(GltfLimits, LightValuesOutOfRangeAreClamped) {
    const auto cones = [](float inner, float outer, size_t warnings) {
        const Light light = load_light(
            {{"type", "spot"}, {"spot", {{"innerConeAngle", inner}, {"outerConeAngle", outer}}}},
            warnings);
        return Vec2(light.inner_cone_angle, light.outer_cone_angle);
    };
    EXPECT_EQ(cones(0.1f, 0.2f, 0), Vec2(0.1f, 0.2f));
    EXPECT_EQ(cones(0, 1.5707964f, 0), Vec2(0, pi / 2));
    EXPECT_EQ(cones(0.3f, 0.2f, 1), Vec2(0.2f, 0.2f));
    EXPECT_EQ(cones(-1, 4, 1), Vec2(0, pi / 2));
    EXPECT_EQ(cones(0, -1, 1), Vec2(0, 0));
    EXPECT_EQ(load_light({{"type", "point"}, {"intensity", -2}}, 1).intensity, 0);
    EXPECT_TRUE(std::isinf(load_light({{"type", "point"}, {"range", 0}}, 1).range));
    EXPECT_EQ(load_light({{"type", "point"}, {"color", {-1, 2, 0}}}, 1).color, Vec3(0, 2, 0));
}

}  // namespace
}  // namespace sightline
