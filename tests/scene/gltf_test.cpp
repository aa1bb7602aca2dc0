#include "support/gltf.h"
#include "core/error.h"
#include "scene/camera_fit.h"
#include "scene/gltf/load.h"

#include <gtest/gtest.h>

#include <numbers>

namespace sightline {
namespace {

using nlohmann::json;

testing::AssertionResult near(const Vec3& a, const Vec3& b, float tolerance = 1e-6f) {
    if ((a - b).length() <= tolerance) return testing::AssertionSuccess();
    return testing::AssertionFailure() << a << " is not " << b;
}

TEST(Gltf, ATriangleInAGlbIsBakedIntoWorldSpace) {
    GltfBuilder file;
    const size_t node = file.triangle();
    file.json["nodes"][node]["translation"] = {1, 2, 3};
    file.json["nodes"][node]["name"] = "leaf";
    const Scene scene = load_gltf(file.save());
    ASSERT_EQ(scene.meshes.size(), 1u);
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_TRUE(scene.instances[0].baked);
    EXPECT_EQ(scene.instances[0].name, "leaf");
    EXPECT_EQ(scene.meshes[0].positions[1], Vec3(2, 2, 3));
    EXPECT_TRUE(scene.meshes[0].normals.empty());
    EXPECT_EQ(scene.meshes[0].material, 0u);
    EXPECT_EQ(scene.bounds.min, Vec3(1, 2, 3));
    EXPECT_EQ(scene.bounds.max, Vec3(2, 3, 3));
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_NE(scene.content_hash, 0u);
}

TEST(Gltf, BuffersComeFromDataUrisAndFilesWithSpacesAndUnicode) {
    GltfBuilder file;
    file.triangle();
    const auto folder = test_folder();
    std::filesystem::create_directories(folder / "a b");
    write_file(folder / "a b" / "ünï ❤%.bin", file.bin);
    for (const char* uri : {"a%20b/%C3%BCn%C3%AF%20%E2%9D%A4%25.bin", "a b/ünï ❤%25.bin",
                            "./a%20b/../a%20b/ünï%20❤%25.bin",
                            "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAA"
                            "AAAAAAAAgD8AAAAA"}) {
        SCOPED_TRACE(uri);
        file.json["buffers"] = {{{"byteLength", file.bin.size()}, {"uri", uri}}};
        const Scene scene = load_gltf(write_file(folder / "test.gltf", file.json.dump()));
        ASSERT_EQ(scene.meshes.size(), 1u);
        EXPECT_EQ(scene.meshes[0].positions[2], Vec3(0, 1, 0));
    }
}

TEST(Gltf, SharedMeshesBecomeInstancesAndAreNeverCopied) {
    GltfBuilder file;
    const size_t first = file.triangle();
    for (int i = 1; i < 5; ++i) {
        file.add("nodes", {{"mesh", file.json["nodes"][first]["mesh"]},
                           {"translation", {i, 0, 0}},
                           {"scale", {i % 2 ? -1 : 1, 1, 1}}});
    }
    const Scene scene = load_gltf(file.save());
    EXPECT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.groups.size(), 1u);
    ASSERT_EQ(scene.instances.size(), 5u);
    for (const Instance& instance : scene.instances) {
        EXPECT_FALSE(instance.baked);
        const Vec3 p(0.3f, 0.2f, 0.1f);
        EXPECT_TRUE(near(
            transform_point(transform_point(p, instance.object_to_world), instance.world_to_object),
            p));
    }
    EXPECT_FALSE(scene.instances[2].mirrored);
    EXPECT_TRUE(scene.instances[3].mirrored);
    EXPECT_EQ(scene.bounds.max, Vec3(5, 1, 0));
    EXPECT_EQ(scene.bounds.min, Vec3(0, 0, 0));
}

TEST(Gltf, ANegativeScaleKeepsFrontFacesAndNormalsOutward) {
    GltfBuilder file;
    const size_t positions = file.floats({0, 0, 1, 1, 0, 1, 0, 1, 1}, "VEC3");
    const size_t normals = file.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
    const size_t tangents = file.floats({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}, "VEC4");
    file.json["materials"] = {
        {{"extensions", {{"KHR_materials_anisotropy", {{"anisotropyStrength", 1}}}}}}};
    const size_t node = file.mesh_node(
        {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}, {"TANGENT", tangents}}},
         {"material", 0}});
    file.json["nodes"][node]["scale"] = {1, 2, -3};
    const Scene scene = load_gltf(file.save());
    const Mesh& mesh = scene.meshes.at(0);
    // Mirrored in z: normals along +z now point along −z, still outwards.
    const auto& t = mesh.triangles.at(0);
    const Vec3 face = cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                            mesh.positions[t[2]] - mesh.positions[t[0]]);
    EXPECT_LT(face.z, 0);
    EXPECT_TRUE(near(mesh.normals[0], {0, 0, -1}));
    EXPECT_EQ(mesh.tangents[0], Vec4(1, 0, 0, -1));
    EXPECT_EQ(mesh.positions[0], Vec3(0, 0, -3));
}

TEST(Gltf, NormalsAreTransformedByTheInverseTranspose) {
    GltfBuilder file;
    const float s = std::numbers::sqrt2_v<float> / 2;
    const size_t node =
        file.mesh_node({{"attributes",
                         {{"POSITION", file.floats({1, 0, 0, 0, 1, 0, 1, 0, 1}, "VEC3")},
                          {"NORMAL", file.floats({s, s, 0, s, s, 0, s, s, 0}, "VEC3")}}}});
    file.json["nodes"][node]["scale"] = {4, 1, 1};
    const Mesh mesh = load_gltf(file.save()).meshes.at(0);
    EXPECT_TRUE(near(mesh.normals[0], normalize(Vec3(0.25f, 1, 0))));
    EXPECT_NEAR(dot(mesh.normals[0], mesh.positions[1] - mesh.positions[0]), 0, 1e-6);
}

TEST(Gltf, TransformsComposeAsScaleThenRotationThenTranslationThenParent) {
    GltfBuilder file;
    const size_t node = file.triangle();
    const float s = std::numbers::sqrt2_v<float> / 2;
    file.json["nodes"][node]["scale"] = {2, 1, 1};
    file.json["nodes"][node]["rotation"] = {0, 0, s, s};  // a quarter turn from x to y
    file.json["nodes"][node]["translation"] = {0, 0, 5};
    file.add("nodes", {{"children", {node}},  // column by column: y ← z, z ← −y, x + 10
                       {"matrix", {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 10, 0, 0, 1}}});
    const Mesh mesh = load_gltf(file.save()).meshes.at(0);
    EXPECT_TRUE(near(mesh.positions[0], {10, -5, 0}));
    EXPECT_TRUE(near(mesh.positions[1], {10, -5, 2}));
    EXPECT_TRUE(near(mesh.positions[2], {9, -5, 0}));
}

TEST(Gltf, EveryTriangleModeGivesTheSpecifiedTriangles) {
    const std::vector<uint16_t> order{0, 1, 2, 3, 4, 2};
    using Triangles = std::vector<std::array<uint32_t, 3>>;
    const std::pair<int, Triangles> modes[] = {
        {4, {{0, 1, 2}, {3, 4, 2}}},
        {5, {{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}},  // the fourth, 3 2 4, is a true one too
        {6, {{1, 2, 0}, {2, 3, 0}, {3, 4, 0}, {4, 2, 0}}},
    };
    for (const auto& [mode, expected] : modes) {
        GltfBuilder file;
        std::vector<float> positions;
        for (int i = 0; i < 5; ++i) {
            positions.insert(positions.end(), {float(i), float(i * i), float(i % 2)});
        }
        file.mesh_node({{"attributes", {{"POSITION", file.floats(positions, "VEC3")}}},
                        {"indices", file.indices(order)},
                        {"mode", mode}});
        Triangles triangles = load_gltf(file.save()).meshes.at(0).triangles;
        if (mode == 5) {
            ASSERT_EQ(triangles.size(), 4u);
            EXPECT_EQ(triangles.back(), (std::array<uint32_t, 3>{3, 2, 4}));
            triangles.pop_back();
        }
        EXPECT_EQ(triangles, expected) << "mode " << mode;
    }
}

TEST(Gltf, StripsMayBeConnectedByDegenerateTriangles) {
    GltfBuilder file;
    file.mesh_node(
        {{"attributes",
          {{"POSITION",
            file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0}, "VEC3")}}},
         {"indices", file.indices({0, 1, 2, 2, 3, 3, 4, 5})},
         {"mode", 5}});
    EXPECT_EQ(load_gltf(file.save()).meshes.at(0).triangles.size(), 2u);
}

TEST(Gltf, PointsAndLinesAreReportedOnce) {
    GltfBuilder file;
    const size_t positions = file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
    for (int mode = 0; mode < 4; ++mode) {
        file.mesh_node({{"attributes", {{"POSITION", positions}}}, {"mode", mode}});
    }
    const Scene scene = load_gltf(file.save());
    EXPECT_TRUE(scene.meshes.empty());
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].find("points or lines"), std::string::npos);
}

TEST(Gltf, NormalisedInterleavedAndPaddedAccessorsAreRead) {
    GltfBuilder file;
    // Stride 8: three bytes of position, one of padding, two 16-bit texture coordinates.
    const size_t view = file.view<uint8_t>({0,   0,   0, 0, 0,    0,    0xff, 0xff,  //
                                            255, 0,   0, 0, 0xff, 0xff, 0,    0,     //
                                            128, 129, 0, 0, 0,    0x80, 0,    0},
                                           8);
    const json normalized = {{"normalized", true}};
    file.mesh_node({{"attributes",
                     {{"POSITION", file.accessor(view, 5120, "VEC3", 3, normalized)},
                      {"TEXCOORD_0", file.accessor(view, 5123, "VEC2", 3,
                                                   {{"normalized", true}, {"byteOffset", 4}})}}}});
    file.json["extensionsUsed"] = file.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    const Mesh mesh = load_gltf(file.save()).meshes.at(0);
    EXPECT_EQ(mesh.positions[1], Vec3(-1 / 127.0f, 0, 0));
    EXPECT_EQ(mesh.positions[2], Vec3(-1, -1, 0));  // −128 and −127 are both −1
    EXPECT_EQ(mesh.texcoords.at(0)[0], Vec2(0, 1));
    EXPECT_EQ(mesh.texcoords[0][1], Vec2(1, 0));
    EXPECT_FLOAT_EQ(mesh.texcoords[0][2].x, 32768 / 65535.0f);
}

TEST(Gltf, SparseAccessorsReplaceSomeElementsOfABaseOrOfZeros) {
    for (const bool with_base : {true, false}) {
        GltfBuilder file;
        const size_t indices = file.view<uint8_t>({0, 2});
        const size_t values = file.view<float>({7, 8, 9, -1, -2, -3});
        const json sparse = {{"count", 2},
                             {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                             {"values", {{"bufferView", values}}}};
        size_t accessor = file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
        file.json["accessors"][accessor]["sparse"] = sparse;
        if (!with_base) file.json["accessors"][accessor].erase("bufferView");
        file.mesh_node({{"attributes", {{"POSITION", accessor}}}});
        const Mesh mesh = load_gltf(file.save()).meshes.at(0);
        EXPECT_EQ(mesh.positions[0], Vec3(7, 8, 9));
        EXPECT_EQ(mesh.positions[1], with_base ? Vec3(1, 0, 0) : Vec3(0, 0, 0));
        EXPECT_EQ(mesh.positions[2], Vec3(-1, -2, -3));
    }
}

TEST(Gltf, OnlyTheVerticesThatAPrimitiveUsesAreKept) {
    GltfBuilder file;
    std::vector<float> positions;
    for (int i = 0; i < 100; ++i) positions.insert(positions.end(), {float(i), float(i * i), 1});
    const size_t accessor = file.floats(positions, "VEC3");
    const size_t node = file.mesh_node(
        {{"attributes", {{"POSITION", accessor}}}, {"indices", file.indices({90, 5, 40})}});
    ASSERT_EQ(node, 0u);
    const Mesh mesh = load_gltf(file.save()).meshes.at(0);
    ASSERT_EQ(mesh.positions.size(), 3u);
    EXPECT_EQ(mesh.positions[mesh.triangles[0][0]].x, 90);
    EXPECT_EQ(mesh.positions[mesh.triangles[0][1]].x, 5);
    EXPECT_EQ(mesh.positions[mesh.triangles[0][2]].x, 40);
}

TEST(Gltf, CamerasAndLightsAreInWorldSpace) {
    GltfBuilder file;
    file.json["cameras"] = {
        {{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}},
        {{"type", "orthographic"},
         {"orthographic", {{"xmag", 2}, {"ymag", 3}, {"znear", 0}, {"zfar", 10}}}}};
    file.json["extensionsUsed"] = {"KHR_lights_punctual"};
    file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "spot"},
         {"intensity", 5},
         {"color", {1, 0.5, 0}},
         {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.2}}}}};
    const float s = std::numbers::sqrt2_v<float> / 2;
    // Rotated by 180° about y and scaled non-uniformly: the camera stays rigid.
    file.add("nodes", {{"camera", 0},
                       {"rotation", {0, 1, 0, 0}},
                       {"scale", {3, 2, 5}},
                       {"translation", {1, 2, 3}},
                       {"name", "eye"}});
    file.add("nodes", {{"camera", 1}});
    file.add("nodes", {{"rotation", {-s, 0, 0, s}},
                       {"translation", {0, 9, 0}},
                       {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    const Scene scene = load_gltf(file.save());
    ASSERT_EQ(scene.cameras.size(), 2u);
    const Camera& eye = scene.cameras[0];
    EXPECT_EQ(eye.name, "eye");
    EXPECT_FLOAT_EQ(eye.yfov, 0.5f);
    EXPECT_TRUE(near(transform_vector({0, 0, -1}, eye.to_world), {0, 0, 1}));
    EXPECT_TRUE(near(transform_vector({1, 0, 0}, eye.to_world), {-1, 0, 0}));
    EXPECT_TRUE(near(transform_point({0, 0, 0}, eye.to_world), {1, 2, 3}));
    EXPECT_TRUE(scene.cameras[1].orthographic);
    EXPECT_EQ(scene.cameras[1].ymag, 3);
    ASSERT_EQ(scene.lights.size(), 1u);
    EXPECT_EQ(scene.lights[0].kind, LightKind::spot);
    EXPECT_TRUE(near(scene.lights[0].direction, {0, -1, 0}));
    EXPECT_TRUE(near(scene.lights[0].position, {0, 9, 0}));
    EXPECT_FLOAT_EQ(scene.lights[0].outer_cone_angle, 0.2f);
    EXPECT_EQ(scene.lights[0].color, Vec3(1, 0.5f, 0));
}

TEST(Gltf, ScenesAreSelectedByNameOrIndex) {
    GltfBuilder file;
    file.triangle();
    file.triangle();
    file.json["nodes"][1]["translation"] = {0, 0, 7};
    file.json["scenes"] = {{{"nodes", {0}}, {"name", "near"}}, {{"nodes", {1}}, {"name", "far"}}};
    const std::string path = file.save();
    const auto depth = [&](const std::string& name) {
        LoadOptions options;
        options.scene = name;
        return load_gltf(path, options).bounds.max.z;
    };
    EXPECT_EQ(depth(""), 0);
    EXPECT_EQ(depth("far"), 7);
    EXPECT_EQ(depth("1"), 7);
    EXPECT_EQ(depth("near"), 0);
    EXPECT_THROW(depth("2"), Error);
    EXPECT_THROW(depth("elsewhere"), Error);
}

TEST(Gltf, GpuInstancingRepeatsOneMesh) {
    GltfBuilder file;
    const size_t node = file.triangle();
    const size_t translations = file.floats({0, 0, 0, 0, 0, 1, 0, 0, 2}, "VEC3");
    const size_t scales = file.floats({1, 1, 1, 2, 2, 2, 3, 3, 3}, "VEC3");
    file.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
    file.json["nodes"][node]["translation"] = {10, 0, 0};
    file.json["nodes"][node]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", translations}, {"SCALE", scales}};
    const Scene scene = load_gltf(file.save());
    EXPECT_EQ(scene.meshes.size(), 1u);
    ASSERT_EQ(scene.instances.size(), 3u);
    EXPECT_TRUE(near(transform_point({1, 0, 0}, scene.instances[2].object_to_world), {13, 0, 2}));
}

TEST(Gltf, HiddenNodesAndTheirChildrenAreNotDrawn) {
    GltfBuilder file;
    const size_t node = file.triangle();
    file.add("nodes", {{"children", {node}},
                       {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
    EXPECT_TRUE(load_gltf(file.save()).instances.empty());
}

TEST(Gltf, UnknownExtensionsWarnWhenUsedAndFailWhenRequired) {
    GltfBuilder file;
    file.triangle();
    file.json["extensionsUsed"] = {"ACME_rockets", "ACME_rockets"};
    const std::string path = file.save();
    const Scene scene = load_gltf(path);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].find("ACME_rockets"), std::string::npos);
    file.json["extensionsRequired"] = {"ACME_rockets"};
    try {
        load_gltf(file.save());
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("extensionsRequired[0]: ACME_rockets"),
                  std::string::npos);
    }
}

TEST(Gltf, TheFittedCameraSeesTheBoundsFromItsDirection) {
    const Camera camera = fit_camera(Box3({-1, -1, -1}, {1, 1, 1}));
    const Vec3 eye = transform_point({0, 0, 0}, camera.to_world);
    const float distance = std::sqrt(3.0f) / std::sin(pi / 8);
    EXPECT_TRUE(near(eye, normalize(Vec3(0.6f, 0.35f, 0.8f)) * distance, 1e-5f));
    EXPECT_TRUE(near(transform_vector({0, 0, -1}, camera.to_world), -normalize(eye)));
    EXPECT_FLOAT_EQ(camera.yfov, pi / 4);
    EXPECT_GT(transform_vector({0, 1, 0}, camera.to_world).y, 0);
    // An empty scene must not give NaN.
    const Vec3 from = transform_point({0, 0, 0}, fit_camera(Box3()).to_world);
    EXPECT_TRUE(std::isfinite(from.x + from.y + from.z));
}

TEST(Gltf, LookingStraightDownIsFinite) {
    const Camera camera = look_at({0, 5, 0}, {0, 0, 0}, {0, 1, 0}, 1);
    EXPECT_TRUE(near(transform_vector({0, 0, -1}, camera.to_world), {0, -1, 0}));
    EXPECT_NEAR(transform_vector({1, 0, 0}, camera.to_world).length(), 1, 1e-6);
}

}  // namespace
}  // namespace sightline
