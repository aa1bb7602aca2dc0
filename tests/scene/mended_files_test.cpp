// What is drawn of files with faults, and what ends a file with one line.
#include "output/render_asset.h"
#include "support/faulty_files.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

using nlohmann::json;

// The x coordinate of the first mesh's first vertex at a time.
float x_at(const std::string& path, float time) {
    LoadOptions options;
    options.time = time;
    return load_gltf(path, options).meshes.at(0).positions.at(0).x;
}

TEST(MendedFiles, OfKeyframesAtOneTimeTheLastHolds) {
    const std::string path = animation_inputs().at(Fault::equal_key_times)();
    EXPECT_FLOAT_EQ(x_at(path, 0.25f), 0.5f);
    EXPECT_FLOAT_EQ(x_at(path, 0.5f), 2);
    EXPECT_FLOAT_EQ(x_at(path, 0.75f), 2.5f);
}

TEST(MendedFiles, NegativeTimesAndSplinesOfOneKeyframeAreSampled) {
    EXPECT_FLOAT_EQ(x_at(animation_inputs().at(Fault::negative_key_time)(), 0), 0.5f);
    EXPECT_FLOAT_EQ(x_at(animation_inputs().at(Fault::one_key_spline)(), 3), 1);
}

TEST(MendedFiles, AnAnimatedMatrixKeepsItsRotationAndScale) {
    LoadOptions options;
    options.time = 1.0f;
    const Scene scene = load_gltf(animation_inputs().at(Fault::animated_matrix)(), options);
    const std::vector<Vec3>& p = scene.meshes.at(0).positions;
    EXPECT_TRUE(p.at(0).equalWithAbsError(Vec3(1, 0, 0), 1e-6f)) << p[0];
    EXPECT_TRUE(p.at(1).equalWithAbsError(Vec3(1, 2, 0), 1e-6f)) << p[1];
    EXPECT_TRUE(p.at(2).equalWithAbsError(Vec3(-1, 0, 0), 1e-6f)) << p[2];
}

TEST(MendedFiles, WithoutAnimationATimePlaysTheFirst) {
    const std::string path = animation_inputs().at(Fault::first_animation)();
    LoadOptions options;
    options.time = 1.0f;
    EXPECT_EQ(load_gltf(path, options).meshes.at(0).positions[0], Vec3(1, 0, 0));
    options.animation = "all";
    EXPECT_EQ(load_gltf(path, options).meshes.at(0).positions[0], Vec3(0, 9, 0));
}

// Where the first vertex of a triangle is whose two morph targets move it by (1, 0, 0) and (10, 0,
// 0).
Vec3 morphed_by(const json& weights) {
    GltfBuilder file;
    const json targets = {{{"POSITION", file.floats({1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3")}},
                          {{"POSITION", file.floats({10, 0, 0, 10, 0, 0, 10, 0, 0}, "VEC3")}}};
    file.mesh_node(primitive_with(file, {{"targets", targets}}));
    file.json["meshes"][0]["weights"] = weights;
    return load_gltf(file.save()).meshes.at(0).positions.at(0);
}

TEST(MendedFiles, MorphWeightsThatAreMissingAre0AndOthersAreLeftOut) {
    EXPECT_EQ(morphed_by({0.5, 0.5}), Vec3(5.5f, 0, 0));
    json one;
    one.push_back(0.5);
    EXPECT_EQ(morphed_by(one), Vec3(0.5f, 0, 0));
    EXPECT_EQ(morphed_by({0.5, 0.5, 7}), Vec3(5.5f, 0, 0));
}

TEST(MendedFiles, AColourKeepsTheNumbersThatItHasAndIsOpaqueWithoutAlpha) {
    const Scene scene = load_gltf(triangle_and(R"({"materials": [
        {"emissiveFactor": [0.5, 0.25, 0.125, 0.75],
         "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0.125]}}]})"));
    EXPECT_EQ(scene.fault_count, 2u);
    EXPECT_EQ(scene.materials.at(1).base_color_factor, Vec4(0.5f, 0.25f, 0.125f, 1));
    EXPECT_EQ(scene.materials.at(1).emissive_factor, Vec3(0.5f, 0.25f, 0.125f));
}

TEST(MendedFiles, AJointWithoutWeightIsPassedOverAndAPrimitiveWithoutJointsStaysAtItsNode) {
    const Scene skinned = load_gltf(deformed_inputs().at(Fault::unused_joint)());
    EXPECT_EQ(skinned.meshes.at(1).positions[0], Vec3(5, 0, 0));
    const Scene unskinned = load_gltf(triangle_and([](GltfBuilder& file) {
        add_skinned(file, {0, 0, 0, 0}, {1, 0, 0, 0});
        file.json["nodes"][1]["translation"] = {0, 3, 0};
        file.json["meshes"][1]["primitives"][0]["attributes"].erase("JOINTS_0");
    }));
    EXPECT_EQ(unskinned.meshes.at(1).positions[0], Vec3(0, 3, 0));
    const Scene weighted = load_gltf(triangle_and([](GltfBuilder& file) {
        add_skinned(file, {0, 9, 0, 0}, {0.5f, 0.5f, 0, 0});
    }));
    EXPECT_EQ(weighted.faults.at(0).key, "primitive");
    EXPECT_EQ(weighted.meshes.size(), 1u);
}

TEST(MendedFiles, ANodeWithFaultyInstancesIsDrawnOnceAndAnInstanceWithoutMatrixNotAtAll) {
    EXPECT_EQ(load_gltf(node_inputs().at(Fault::instances)()).instances.size(), 1u);
    EXPECT_EQ(load_gltf(node_inputs().at(Fault::instance)()).instances.size(), 2u);
}

TEST(MendedFiles, ABrokenCameraKeepsItsNumberAndEndsOnlyWhatAsksForIt) {
    const auto cameras = [](const json& broken) {
        return load_gltf(triangle_and([&](GltfBuilder& file) {
            const json sound = {{"type", "perspective"},
                                {"perspective", {{"yfov", 1}, {"znear", 1}}}};
            file.json["cameras"] = {broken, sound};
            for (int i = 0; i < 2; ++i) file.add("nodes", {{"camera", i}});
        }));
    };
    const json bad_lens = {{"type", "perspective"}, {"perspective", {{"yfov", 0}, {"znear", 1}}}};
    for (const json& broken : {bad_lens, json(5), json::parse(R"({"type": "fisheye"})")}) {
        SCOPED_TRACE(broken.dump());
        const Scene scene = cameras(broken);
        ASSERT_EQ(scene.cameras.size(), 2u);
        EXPECT_FALSE(scene.cameras[0].fault.empty());
        EXPECT_EQ(scene.cameras[1].yfov, 1);
        RenderCommand command;
        EXPECT_EQ(complete_settings(command, scene).camera.yfov, 1);
        command.view.camera = "1";
        EXPECT_EQ(complete_settings(command, scene).camera.yfov, 1);
        command.view.camera = "0";
        EXPECT_THROW(complete_settings(command, scene), Error);
        command.view.camera = "fit";
        EXPECT_NO_THROW(complete_settings(command, scene));
    }
}

TEST(MendedFiles, TexturesThatNoPixelDependsOnAreNotRead) {
    const auto images_read = [](const char* material) {
        return triangle_and([&](GltfBuilder& file) {
            file.json["images"] = {{{"uri", "missing.png"}}};
            file.json["textures"] = {{{"source", 0}}};
            file.json["materials"].push_back(json::parse(material));
            file.json["meshes"][0]["primitives"][0]["material"] = 0;
        });
    };
    for (const char* material :
         {R"({"normalTexture": {"index": 0}, "extensions": {"KHR_materials_unlit": {}}})",
          R"({"emissiveTexture": {"index": 0}})",
          R"({"extensions": {"KHR_materials_clearcoat": {"clearcoatTexture": {"index": 0}}}})"}) {
        SCOPED_TRACE(material);
        EXPECT_TRUE(load_gltf(images_read(material), posed(true)).warnings.empty());
    }
}

TEST(MendedFiles, MorphTargetsMoveColoursAndTextureCoordinates) {
    GltfBuilder file;
    const json colors = {{"COLOR_0", file.floats({1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3")},
                         {"TEXCOORD_0", file.floats({0, 0, 1, 0, 0, 1}, "VEC2")}};
    const json target = {{"COLOR_0", file.floats({0, 1, 0, 0, 1, 0, 0, 4, 0}, "VEC3")},
                         {"TEXCOORD_0", file.floats({2, 0, 2, 0, 2, 0}, "VEC2")}};
    file.mesh_node(
        primitive_with(file, {{"attributes", colors}, {"targets", json::array({target})}}));
    file.json["meshes"][0]["weights"].push_back(0.5);
    const Mesh mesh = load_gltf(file.save(), posed(true)).meshes.at(0);
    EXPECT_EQ(mesh.colors.at(0), Vec4(1, 0.5f, 0, 1));
    EXPECT_EQ(mesh.colors.at(2), Vec4(1, 1, 0, 1));
    EXPECT_EQ(mesh.texcoords.at(0).at(1), Vec2(2, 0));
}

TEST(MendedFiles, PrimitivesThatAreNotDrawnMayHaveAnyIndices) {
    const Scene scene =
        load_gltf(triangle_and([](GltfBuilder& file) {
                      file.mesh_node(primitive_with(
                          file, {{"mode", 3}, {"indices", file.indices({0, 65535, 1})}}));
                  }),
                  posed(true));
    EXPECT_EQ(scene.meshes.size(), 1u);
}

TEST(MendedFiles, AMeshoptPlaceholderNeedsNoMark) {
    GltfBuilder file;
    file.triangle();
    file.json["buffers"] = {{{"byteLength", 36}, {"uri", "data:;base64," + std::string(48, 'A')}},
                            {{"byteLength", 16}}};
    const std::string path = write_file(test_folder() / "test.gltf", file.json.dump());
    EXPECT_TRUE(load_gltf(path, posed(true)).warnings.empty());
    file.json["images"] = {
        {{"bufferView", file.add("bufferViews", {{"buffer", 1}, {"byteLength", 16}})}}};
    write_file(path, file.json.dump());
    EXPECT_TRUE(fails(path, "buffers[1]: has no uri"));
}

TEST(MendedFiles, ABufferThatNothingNeedsIsNotOpened) {
    const json sound = {{"byteLength", 36}, {"uri", triangle_buffer()}};
    for (const char* uri : {"missing.bin", "../outside.bin", "/dev/zero", "http://a.b/c.bin",
                            "data:;base64,AAAA", "data:;base64,?"}) {
        SCOPED_TRACE(uri);
        const std::string path =
            text_buffers(json::array({sound, {{"byteLength", 99}, {"uri", uri}}}));
        const Scene scene = load_gltf(path, posed(true));
        EXPECT_EQ(scene.instances.size(), 1u);
        EXPECT_TRUE(scene.warnings.empty());
        EXPECT_EQ(scene.files.size(), 1u);
        EXPECT_EQ(load_gltf(path, all_faults(true)).warnings.size(), 1u);
    }
}

TEST(MendedFiles, WhatNothingNeedsMayLieInABufferThatIsNotThere) {
    // An accessor that nothing uses, and a motion: without a time, no byte of it is read.
    GltfBuilder file;
    file.triangle();
    add_motion(file, {0, 1}, {0, 0, 0, 1, 0, 0});
    for (size_t view = 1; view < 3; ++view)
        file.json["bufferViews"][view].update({{"buffer", 1}, {"byteOffset", 0}});
    file.add("bufferViews", {{"buffer", 1}, {"byteLength", 24}});
    file.add("accessors",
             {{"bufferView", 3}, {"componentType", 5126}, {"type", "VEC3"}, {"count", 2}});
    file.json["buffers"] = {{{"byteLength", 36}, {"uri", triangle_buffer()}},
                            {{"byteLength", 24}, {"uri", "missing.bin"}}};
    const std::string path = write_file(test_folder() / "test.gltf", file.json.dump());
    LoadOptions strict;
    strict.strict = true;
    EXPECT_TRUE(load_gltf(path, strict).warnings.empty());
    EXPECT_TRUE(fails(path, "buffers[1].uri: 'missing.bin'", posed(true)));
    EXPECT_TRUE(fails(path, "buffers[1].uri: 'missing.bin'", all_faults(true)));
}

// A sparse accessor whose index is that of no element.
size_t add_broken_sparse(GltfBuilder& file, const char* type, size_t count, size_t components) {
    const size_t indices = file.view(std::vector<uint16_t>{99});
    const size_t values = file.view(std::vector<float>(components));
    return file.add("accessors", {{"componentType", 5126},
                                  {"type", type},
                                  {"count", count},
                                  {"sparse",
                                   {{"count", 1},
                                    {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                                    {"values", {{"bufferView", values}}}}}});
}

// The faults of a file, which is drawn.
std::vector<FoundFault> faults_of(const Change& change) {
    const Scene scene = load_gltf(triangle_and(change), posed(false));
    EXPECT_FALSE(scene.instances.empty());
    return scene.faults;
}

TEST(MendedFiles, ASparseIndexOutOfRangeCostsWhatItIsIn) {
    const auto bones = faults_of([](GltfBuilder& file) {
        add_skinned(file, {0, 0, 0, 0}, {1, 0, 0, 0});
        file.json["skins"][0]["inverseBindMatrices"] = add_broken_sparse(file, "MAT4", 1, 16);
    });
    ASSERT_EQ(bones.size(), 1u);
    EXPECT_EQ(bones[0].key, "skin");
    const auto keys = faults_of([](GltfBuilder& file) {
        add_motion(file, {0, 1}, {0, 0, 0, 1, 0, 0});
        file.json["animations"][0]["samplers"][0]["output"] = add_broken_sparse(file, "VEC3", 2, 3);
    });
    ASSERT_EQ(keys.size(), 1u);
    EXPECT_EQ(keys[0].key, "channel");
    const auto instances = faults_of([](GltfBuilder& file) {
        file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
            {"TRANSLATION", add_broken_sparse(file, "VEC3", 2, 3)}};
    });
    ASSERT_EQ(instances.size(), 1u);
    EXPECT_EQ(instances[0].key, "instances");
    for (const char* attribute : {"POSITION", "NORMAL", "COLOR_0"}) {
        SCOPED_TRACE(attribute);
        const auto vertices = faults_of([&](GltfBuilder& file) {
            file.mesh_node(primitive_with(
                file, {{"attributes", {{attribute, add_broken_sparse(file, "VEC3", 3, 3)}}}}));
        });
        ASSERT_EQ(vertices.size(), 1u);
        EXPECT_EQ(vertices[0].key, "primitive");
    }
}

// How many instances a file has, and by how many faults.
using Rest = std::pair<size_t, uint64_t>;
Rest rest_of(const std::string& path) {
    const Scene scene = load_gltf(path, posed(false));
    return {scene.instances.size(), scene.fault_count};
}

TEST(MendedFiles, WhatIsDroppedIsNotUsed) {
    EXPECT_EQ(rest_of(deformed_inputs().at(Fault::skin)()), Rest(2, 1));
    EXPECT_EQ(rest_of(mesh_inputs().at(Fault::draco_stream)()), Rest(1, 1));
    EXPECT_EQ(load_gltf(node_inputs().at(Fault::second_parent)()).warnings.size(), 1u);
    // The stream's view, the accessor in it and the primitive that uses that.
    EXPECT_EQ(
        rest_of(triangle_and([](GltfBuilder& file) {
            add_compressed_view(file);
            const size_t view = file.json["bufferViews"].size() - 1;
            file.mesh_node({{"attributes", {{"POSITION", file.accessor(view, 5126, "VEC3", 1)}}}});
        })),
        Rest(1, 3));
    EXPECT_EQ(
        rest_of(triangle_and([](GltfBuilder& file) {
            file.mesh_node({{"attributes", {{"POSITION", file.accessor(0, 5126, "VEC3", 4)}}}});
        })),
        Rest(1, 2));
}

TEST(MendedFiles, OfTwoChannelsForOnePropertyTheFirstMovesIt) {
    const std::string path = triangle_and([](GltfBuilder& file) {
        add_motion(file, {0, 1}, {0, 0, 0, 1, 0, 0});
        json& motion = file.json["animations"][0];
        motion["samplers"].push_back({{"input", motion["samplers"][0]["input"]},
                                      {"output", file.floats({9, 9, 9, 9, 9, 9}, "VEC3")}});
        motion["channels"].push_back(motion["channels"][0]);
        motion["channels"][1]["sampler"] = 1;
    });
    EXPECT_FLOAT_EQ(x_at(path, 0.5f), 0.5f);
    EXPECT_EQ(rest_of(path), Rest(1, 1));
}

TEST(MendedFiles, AChannelWithoutSamplerLeavesItsNodeAtRest) {
    const std::string path = triangle_and([](GltfBuilder& file) {
        add_motion(file, {0, 1}, {5, 0, 0, 5, 0, 0});
        file.json["animations"][0]["channels"][0]["sampler"] = 1;
    });
    EXPECT_FLOAT_EQ(x_at(path, 0.5f), 0);
    EXPECT_EQ(rest_of(path), Rest(1, 1));
}

TEST(MendedFiles, AnythingMayStandInPlaceOfAListOrAName) {
    for (const char* list : {"animations", "cameras", "images", "materials", "samplers", "skins",
                             "textures", "scenes", "extensionsUsed"}) {
        for (const char* value : {"null", "5", "\"none\"", "{}", "[]"}) {
            SCOPED_TRACE(std::string(list) + ": " + value);
            const Scene scene = load_gltf(
                triangle_and([&](GltfBuilder& file) { file.json[list] = json::parse(value); }),
                posed(false));
            EXPECT_EQ(scene.instances.size(), 1u);
            EXPECT_LE(scene.fault_count, 1u);
        }
    }
    const Scene scene = load_gltf(triangle_and(R"({"nodes": [{"mesh": 0, "name": 5}]})"));
    EXPECT_EQ(scene.instances.at(0).name, "");
    EXPECT_EQ(scene.fault_count, 1u);
}

TEST(MendedFiles, InfoLooksAtWhatThisPictureDoesNotNeed) {
    const auto keys_of = [](const Change& change) {
        GltfBuilder file;
        file.triangle();
        file.json["scenes"] = {{{"nodes", {0}}}};
        change(file);
        const std::string path = file.save();
        EXPECT_EQ(load_gltf(path).fault_count, 0u);
        std::vector<std::string> keys;
        for (const FoundFault& fault : load_gltf(path, all_faults()).faults)
            keys.push_back(fault.key);
        return keys;
    };
    using Keys = std::vector<std::string>;
    // A mesh of another scene; a morph target without weight; the material of a variant, whose
    // texture reads a broken set; an image that no texture uses; a second animation.
    EXPECT_EQ(keys_of([](GltfBuilder& file) {
                  file.mesh_node(primitive_with(file, {{"indices", file.indices({0, 1, 9})}}));
              }),
              Keys{"primitive"});
    EXPECT_EQ(keys_of([](GltfBuilder& file) {
                  file.json["meshes"][0]["primitives"][0]["targets"] = {
                      {{"POSITION", file.floats({0, 0, 0}, "VEC3")}}};
              }),
              Keys{"primitive"});
    EXPECT_EQ(
        keys_of([](GltfBuilder& file) {
            file.json["images"] = {{{"uri", "missing.png"}}, {{"bufferView", file.view(Bytes(9))}}};
        }),
        (Keys{"missing-texture", "unreadable-texture"}));
    EXPECT_EQ(keys_of([](GltfBuilder& file) {
                  add_motion(file, {0, 1}, {0, 0, 0, 1, 0, 0});
                  add_motion(file, {-1, 1}, {0, 0, 0, 1, 0, 0});
              }),
              Keys{"negative-key-time"});
}

TEST(MendedFiles, InfoGivesTheContentsOfThePictureAskedFor) {
    const std::string path = triangle_and([](GltfBuilder& file) {
        add_motion(file, {0, 1}, {0, 0, 0, 8, 0, 0});
        file.json["images"] = {{{"uri", "missing.png"}}};
    });
    LoadOptions posed_info = all_faults();
    posed_info.time = 0.5f;
    const Scene info = load_gltf(path, posed_info), picture = load_gltf(path, posed(false));
    EXPECT_EQ(info.bounds, picture.bounds);
    EXPECT_EQ(info.content_hash, picture.content_hash);
    EXPECT_EQ(load_gltf(path, all_faults()).bounds, load_gltf(path).bounds);
}

TEST(MendedFiles, MessagesNameTheFileThePlaceAndTheCure) {
    const auto path = test_folder() / "test.gltf";
    const std::pair<const char*, const char*> cases[] = {
        {R"({"asset": {"version": "2.0"},
 "a": 1e309})",
         "JSON: a number is out of range at line 2, column "},
        {R"({"meshes": {"m": {}}})", "asset.version: this is glTF 1.0"},
        {R"({"asset": {"version": "1.0"}, "accessors": {}})", "gltf-pipeline converts it"},
        {R"({"asset": {"version": 1}})", "asset.version: this is glTF 1.0"},
        {R"({"asset": {"version": "2.0")", "JSON: is malformed at line 1, column "},
        {"\xFF\xFE{", "JSON: is UTF-16"},
    };
    for (const auto& [text, message] : cases) {
        SCOPED_TRACE(text);
        EXPECT_TRUE(fails(write_file(path, text), message));
    }
}

}  // namespace
}  // namespace sightline
