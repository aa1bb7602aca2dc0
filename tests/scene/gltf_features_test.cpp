// Rare features of glTF.
#include "core/error.h"
#include "scene/gltf/load.h"
#include "support/gltf.h"

#include <gtest/gtest.h>

#include <numbers>

namespace sightline {
namespace {

using nlohmann::json;

const float half_turn_part = std::numbers::sqrt2_v<float> / 2;  // of a quarter turn's quaternion

const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0};

/// A red and a green pixel, as a PNG in base64.
const std::string png =
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAIAAAB7QOjdAAAAD0lEQVR4nGP4z8DA8J8BAAf/Af8Bf4mn"
    "AAAAAElFTkSuQmCC";

TEST(GltfFeatures, ColoursHaveThreeOrFourComponentsOfAnyType) {
    GltfBuilder file;
    const json normalized = {{"normalized", true}};
    const size_t bytes = file.view<uint8_t>({255, 0, 51, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 4);
    const size_t shorts = file.view<uint16_t>({65535, 0, 13107, 32768, 0, 0, 0, 0, 0, 0, 0, 0});
    const size_t accessors[] = {file.accessor(bytes, 5121, "VEC3", 3, normalized),
                                file.accessor(shorts, 5123, "VEC4", 3, normalized),
                                file.floats({1, 0, 0.2f, 0, 0, 0, 0, 0, 0}, "VEC3")};
    for (const size_t accessor : accessors)
        file.mesh_node({{"attributes",
                         {{"POSITION", file.floats(corners, "VEC3")},
                          {"COLOR_0", accessor},
                          {"COLOR_1", accessor}}}});
    const Scene scene = load_gltf(file.save());
    for (const Mesh& mesh : scene.meshes) {
        EXPECT_EQ(mesh.colors[0].x, 1);
        EXPECT_FLOAT_EQ(mesh.colors[0].z, 0.2f);
        EXPECT_NEAR(mesh.colors[0].w, mesh.colors.data() == scene.meshes[1].colors.data() ? 0.5 : 1,
                    1e-4);
    }
}

TEST(GltfFeatures, OnlyTheTextureCoordinatesThatTheMaterialUsesAreRead) {
    GltfBuilder file;
    file.json["images"] = {{{"uri", "data:;base64," + png}}};
    file.json["textures"] = {{{"source", 0}}};
    file.json["materials"] = {
        {{"emissiveTexture", {{"index", 0}, {"texCoord", 7}}}, {"emissiveFactor", {1, 1, 1}}}};
    file.mesh_node({{"attributes",
                     {{"POSITION", file.floats(corners, "VEC3")},
                      {"TEXCOORD_3", file.floats({0, 0, 0, 0, 0, 0}, "VEC2")},
                      {"TEXCOORD_7", file.floats({1, 2, 3, 4, 5, 6}, "VEC2")}}},
                    {"material", 0}});
    const Scene scene = load_gltf(file.save());
    const Mesh& mesh = scene.meshes.at(0);
    ASSERT_EQ(mesh.texcoords.size(), 8u);
    EXPECT_EQ(mesh.texcoords[7][2], Vec2(5, 6));
    EXPECT_TRUE(mesh.texcoords[3].empty());
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(GltfFeatures, ImagesAreRecognisedByContentNotByUri) {
    for (const std::string prefix :
         {"data:image/png;base64,", "data:image/jpeg;base64,", "data:image/ktx2;base64,",
          "data:;base64,", "data:application/octet-stream;name=a.png;base64,",
          "DATA:text/plain;charset=utf-8;base64,"}) {
        SCOPED_TRACE(prefix);
        std::string encoded = png;
        if (prefix.ends_with("plain;charset=utf-8;base64,"))
            while (encoded.ends_with('=')) encoded.replace(encoded.size() - 1, 1, "%3D");
        GltfBuilder file;
        file.json["images"] = {{{"uri", prefix + encoded}, {"mimeType", "image/jpeg"}}};
        file.json["textures"] = {{{"source", 0}}};
        file.json["materials"] = {
            {{"emissiveTexture", {{"index", 0}}}, {"emissiveFactor", {1, 1, 1}}}};
        file.mesh_node({{"attributes",
                         {{"POSITION", file.floats(corners, "VEC3")},
                          {"TEXCOORD_0", file.floats({0, 0, 1, 0, 0, 1}, "VEC2")}}},
                        {"material", 0}});
        const Scene scene = load_gltf(file.save());
        ASSERT_EQ(scene.images.at(0).width, 2);
        EXPECT_EQ(scene.images[0].bytes[4], 255);
    }
}

TEST(GltfFeatures, TangentsAreReadOrComputedOnlyIfTheMaterialNeedsThem) {
    const auto tangents = [](const json& material) {
        GltfBuilder file;
        file.json["images"] = {{{"uri", "data:;base64," + png}}};
        file.json["textures"] = {{{"source", 0}}};
        file.json["materials"] = json::array({material});
        const size_t up = file.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
        const size_t uv = file.floats({0, 0, 1, 0, 0, 1}, "VEC2");
        const size_t along = file.floats({0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1}, "VEC4");
        const json attributes = {
            {"POSITION", file.floats(corners, "VEC3")}, {"NORMAL", up}, {"TEXCOORD_0", uv}};
        json given = attributes;
        given["TANGENT"] = along;
        file.mesh_node({{"attributes", attributes}, {"material", 0}});
        file.mesh_node({{"attributes", given}, {"material", 0}});
        const Scene scene = load_gltf(file.save());
        std::vector<Vec4> first;
        for (const Mesh& mesh : scene.meshes)
            if (!mesh.tangents.empty()) first.push_back(mesh.tangents[0]);
        return first;
    };
    const std::vector<Vec4> both{{1, 0, 0, -1}, {0, 1, 0, 1}};  // computed, given
    EXPECT_EQ(tangents(json::object()).size(), 0u);
    EXPECT_EQ(tangents({{"emissiveTexture", {{"index", 0}}}}).size(), 0u);
    EXPECT_EQ(tangents({{"normalTexture", {{"index", 0}}}}), both);
    EXPECT_EQ(
        tangents({{"extensions", {{"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}}}}}}),
        both);
    EXPECT_EQ(tangents({{"normalTexture", {{"index", 0}}},
                        {"extensions", {{"KHR_materials_unlit", json::object()}}}})
                  .size(),
              0u);
}

TEST(GltfFeatures, TheFilesDefaultSceneIsLoadedUnlessAnotherIsSelected) {
    GltfBuilder file;
    file.triangle();
    file.triangle();
    file.json["nodes"][1]["translation"] = {0, 0, 7};
    file.json["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1}}}};
    file.json["scene"] = 1;
    EXPECT_EQ(load_gltf(file.save()).bounds.min.z, 7);
}

TEST(GltfFeatures, NamesMayLookLikeStructureAndMembersMayBeRepeatedOrEscaped) {
    const std::string name = "}],\"\\{[:";
    GltfBuilder file;
    file.json["asset"]["generator"] = name;
    file.triangle();
    file.json["meshes"][0]["name"] = name;
    EXPECT_EQ(load_gltf(file.save()).meshes.at(0).name, name);
    // Positions without a buffer view are zeros.
    const char* rest = R"("asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
        "accessors": [{"componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [], )";
    const char* meshes = R"([{"name": "last", "primitives": [{"attributes": {"POSITION": 0}}]}]})";
    for (const char* member : {R"("meshes": )", R"("me\u0073hes": )"}) {
        const Scene scene = load_gltf(
            write_file(test_folder() / "text.gltf", std::string("{") + rest + member + meshes));
        ASSERT_EQ(scene.meshes.size(), 1u) << member;
        EXPECT_EQ(scene.meshes[0].name, "last");
    }
}

TEST(GltfFeatures, AWebpImageIsPreferredToItsFallback) {
    GltfBuilder file;
    file.json["images"] = {{{"uri", "a.png"}}, {{"uri", "a.webp"}}, {{"uri", "a.avif"}}};
    file.json["textures"] = {
        {{"source", 0}},
        {{"source", 0}, {"extensions", {{"EXT_texture_webp", {{"source", 1}}}}}},
        {{"extensions", {{"EXT_texture_avif", {{"source", 2}}}}}},
        {{"source", 0}, {"extensions", {{"KHR_texture_basisu", {{"source", 2}}}}}}};
    const Scene scene = load_gltf(file.save());
    for (const auto& [texture, image] : {std::pair{0, 0u}, {1, 1u}, {2, 2u}, {3, 0u}})
        EXPECT_EQ(scene.textures.at(size_t(texture)).image, image) << texture;
}

/// A triangle with a morph target that moves it by 1, skinned to node 1.
GltfBuilder puppet() {
    GltfBuilder file;
    const size_t lifted = file.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
    const size_t joints =
        file.accessor(file.view<uint8_t>(std::vector<uint8_t>(12, 0)), 5121, "VEC4", 3);
    const size_t weights =
        file.accessor(file.view<uint8_t>({255, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0}), 5121, "VEC4",
                      3, {{"normalized", true}});
    file.mesh_node({{"attributes",
                     {{"POSITION", file.floats(corners, "VEC3")},
                      {"JOINTS_0", joints},
                      {"WEIGHTS_0", weights}}},
                    {"targets", {{{"POSITION", lifted}}}}});
    file.json["nodes"][0]["skin"] = 0;
    file.json["nodes"][0]["translation"] = {100, 0, 0};  // of no effect: the joint places it
    file.add("nodes", {{"name", "joint"}});
    file.json["skins"] = {{{"joints", {1}}}};
    return file;
}

void animate(GltfBuilder& file, size_t node, const char* path, size_t output, const char* how) {
    const size_t times = file.floats({0, 1}, "SCALAR");
    file.add("animations",
             {{"samplers", {{{"input", times}, {"output", output}, {"interpolation", how}}}},
              {"channels", {{{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}}}}});
}

TEST(GltfFeatures, MorphTargetsSkinAndAnimationsWorkTogether) {
    GltfBuilder file = puppet();
    const size_t weights =
        file.accessor(file.view<uint8_t>({0, 255}), 5121, "SCALAR", 2, {{"normalized", true}});
    animate(file, 0, "weights", weights, "LINEAR");
    const float s = half_turn_part;
    animate(file, 1, "rotation", file.floats({0, 0, 0, 1, 0, s, 0, s}, "VEC4"), "STEP");
    LoadOptions options;
    options.time = 1.0f;
    options.animation = "all";
    Scene scene = load_gltf(file.save(), options);
    // Moved from z = 0 to 1, then rotated by 90° about y: z becomes x, x becomes −z.
    EXPECT_LT((scene.meshes.at(0).positions[1] - Vec3(1, 0, -1)).length(), 1e-6f);
    options.time = 0.5f;
    scene = load_gltf(file.save(), options);
    EXPECT_LT((scene.meshes.at(0).positions[1] - Vec3(1, 0, 0.5f)).length(), 1e-6f);
    EXPECT_EQ(load_gltf(file.save()).meshes.at(0).positions[1], Vec3(1, 0, 0));
}

TEST(GltfFeatures, RotationsOnACubicSplineStayUnit) {
    GltfBuilder file;
    file.triangle();
    const float s = half_turn_part;
    // In-tangent, value, out-tangent, twice; between keyframes the spline leaves the unit sphere.
    animate(file, 0, "rotation",
            file.floats({0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0,  //
                         0, 0, 0, 0, 0, 0, s, s, 0, 0, 0, 0},
                        "VEC4"),
            "CUBICSPLINE");
    LoadOptions options;
    options.time = 0.5f;
    const Mesh mesh = load_gltf(file.save(), options).meshes.at(0);
    EXPECT_NEAR(mesh.positions[1].length(), 1, 1e-6);
    EXPECT_NEAR(mesh.positions[1].y, half_turn_part, 1e-6);  // an eighth of a turn
}

TEST(GltfFeatures, InstanceRotationsMayBeIntegersAndSkinnedMeshesHaveNoInstances) {
    GltfBuilder file;
    file.triangle();
    const size_t turns = file.accessor(file.view<int16_t>({0, 0, 0, 32767, 0, 0, 23170, 23170}),
                                       5122, "VEC4", 2, {{"normalized", true}});
    const json instancing = {{"EXT_mesh_gpu_instancing", {{"attributes", {{"ROTATION", turns}}}}}};
    file.json["nodes"][0]["extensions"] = instancing;
    const Scene scene = load_gltf(file.save());
    ASSERT_EQ(scene.instances.size(), 2u);
    const Vec3 turned = transform_point({1, 0, 0}, scene.instances[1].object_to_world);
    EXPECT_LT((turned - Vec3(0, 1, 0)).length(), 1e-4f);

    GltfBuilder skinned = puppet();
    skinned.json["nodes"][0]["extensions"] = {
        {"EXT_mesh_gpu_instancing",
         {{"attributes", {{"TRANSLATION", skinned.floats({0, 0, 0, 1, 1, 1}, "VEC3")}}}}}};
    const Scene one = load_gltf(skinned.save());
    EXPECT_EQ(one.instances.size(), 1u);
    ASSERT_EQ(one.warnings.size(), 1u);
    EXPECT_TRUE(one.warnings[0].starts_with("nodes[0].extensions.EXT_mesh_gpu_instancing"));
}

}  // namespace
}  // namespace sightline
