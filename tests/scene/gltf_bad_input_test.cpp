#include "support/gltf.h"

#include <gtest/gtest.h>

#include <limits>

namespace sightline {
namespace {

using nlohmann::json;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

TEST(GltfBadInput, AccessorsWithHugeNumbersStayWithinTheirData) {
    const std::pair<json, const char*> cases[] = {
        {{{"count", 4}}, "accessors[0]: exceeds its buffer view"},
        {{{"count", 1000000000}}, "exceeds its buffer view"},
        {{{"count", 500000000}}, "exceeds its buffer view"},
        {{{"count", 1u << 31}, {"byteOffset", 0}}, "exceeds its buffer view"},
        {{{"count", 9007199254740992}}, "exceeds its buffer view"},
        {{{"count", 18446744073709551615u}}, "accessors[0].count: 18446744073709551615 is above"},
        {{{"count", -3}}, "accessors[0].count: is not a non-negative integer"},
        {{{"count", 3.5}}, "accessors[0].count"},
        {{{"byteOffset", 9007199254740991}}, "exceeds its buffer view"},
        {{{"byteOffset", 1}}, "exceeds its buffer view"},
        {{{"componentType", 5124}}, "accessors[0].componentType: 5124 is not one of"},
        {{{"type", "VEC5"}}, "accessors[0].type: \"VEC5\" is not one of"},
        {{{"type", "VEC2"}}, "meshes[0].primitives[0].attributes.POSITION"},
        {{{"componentType", 5125}}, "meshes[0].primitives[0].attributes.POSITION"},
        {{{"bufferView", 1}}, "accessors[0].bufferView: 1 is out of range: there are 1"},
    };
    for (const auto& [change, message] : cases) {
        SCOPED_TRACE(change.dump());
        GltfBuilder file;
        file.triangle();
        file.json["accessors"][0].update(change);
        EXPECT_TRUE(fails(file.save(), message));
    }
}

TEST(GltfBadInput, ElementsWithoutDataHaveALimit) {
    GltfBuilder file;
    file.triangle();
    file.json["accessors"][0].erase("bufferView");
    file.json["accessors"][0]["count"] = 500000000;
    EXPECT_TRUE(fails(file.save(), "accessors[0].count: 500000000 elements without data"));
}

TEST(GltfBadInput, BufferViewsStayWithinTheirBuffers) {
    const std::pair<json, const char*> cases[] = {
        {{{"byteLength", 37}}, "bufferViews[0]: bytes 0 + 37 exceed its buffer of 36 bytes"},
        {{{"byteOffset", 9007199254740992}}, "exceed its buffer"},
        {{{"byteOffset", 36}}, "exceed its buffer"},
        {{{"byteStride", 8}}, "accessors[0]: elements of 12 bytes overlap"},
        {{{"byteStride", 13}}, "bufferViews[0].byteStride: is not a multiple of 4"},
        {{{"byteStride", 256}}, "bufferViews[0].byteStride: 256 is above 252"},
        {{{"buffer", 4294967296}}, "bufferViews[0].buffer: 4294967296 is out of range"},
    };
    for (const auto& [change, message] : cases) {
        SCOPED_TRACE(change.dump());
        GltfBuilder file;
        file.triangle();
        file.json["bufferViews"][0].update(change);
        EXPECT_TRUE(fails(file.save(), message));
    }
}

TEST(GltfBadInput, IndicesAndAttributesMustAgree) {
    const auto primitive = [](GltfBuilder& file, const json& more) {
        json p = {{"attributes", {{"POSITION", file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3")}}}};
        p.merge_patch(more);
        file.mesh_node(p);
        return file.save();
    };
    GltfBuilder range, type, count, colors, huge;
    EXPECT_TRUE(fails(primitive(range, {{"indices", range.indices({0, 1, 3})}}),
                      "meshes[0].primitives[0].indices: index 3 at 2 is out of range"));
    EXPECT_TRUE(fails(primitive(type, {{"indices", type.floats({0, 1, 2}, "SCALAR")}}),
                      "meshes[0].primitives[0].indices"));
    EXPECT_TRUE(
        fails(primitive(count, {{"attributes", {{"NORMAL", count.floats({0, 0, 1}, "VEC3")}}}}),
              "meshes[0].primitives[0].attributes.NORMAL: has 1 elements, but POSITION 3"));
    EXPECT_TRUE(fails(
        primitive(colors, {{"attributes", {{"COLOR_0", colors.floats({1, 1, 1}, "SCALAR")}}}}),
        "attributes.COLOR_0"));
    const size_t uv = huge.floats({0, 0, 0, 0, 0, 0}, "VEC2");
    huge.json["materials"] = {{{"normalTexture", {{"index", 0}, {"texCoord", 2147483647}}}}};
    huge.json["textures"] = {{{"source", 0}}};
    huge.json["images"] = {{{"uri", "none.png"}}};
    EXPECT_TRUE(
        fails(primitive(huge, {{"material", 0}, {"attributes", {{"TEXCOORD_2147483647", uv}}}}),
              "TEXCOORD_2147483647 is above the limit"));
}

TEST(GltfBadInput, SparseAccessorsAreChecked) {
    const std::pair<const char*, const char*> cases[] = {
        {R"({"count": 4})", "accessors[0].sparse.count: is above the accessor's count"},
        {R"({"count": 3})", "accessors[0].sparse.indices: exceeds its buffer view"},
        {R"({"values": {"byteOffset": 4}})", "accessors[0].sparse.values: exceeds"},
        {R"({"values": {"byteOffset": 4294967296}})", "accessors[0].sparse.values.byteOffset"},
        {R"({"indices": {"byteOffset": 2147483647}})", "accessors[0].sparse.indices: exceeds"},
        {R"({"indices": {"bufferView": 0}})", "sparse.indices: index "},
        {R"({"indices": {"componentType": 5126}})", "sparse.indices.componentType"},
    };
    for (const auto& [change, message] : cases) {
        SCOPED_TRACE(change);
        GltfBuilder file;
        file.mesh_node(
            {{"attributes", {{"POSITION", file.floats({9, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3")}}}});
        json& sparse = file.json["accessors"][0]["sparse"];
        sparse = {
            {"count", 2},
            {"indices", {{"bufferView", file.view<uint16_t>({0, 2})}, {"componentType", 5123}}},
            {"values", {{"bufferView", file.view<float>({1, 2, 3, 4, 5, 6})}}}};
        EXPECT_TRUE(loads(file.save()));
        sparse.merge_patch(json::parse(change));
        EXPECT_TRUE(fails(file.save(), message));
    }
}

TEST(GltfBadInput, TheNodeHierarchyMustBeAForest) {
    GltfBuilder self, ring, parents;
    self.add("nodes", {{"children", {0}}});
    EXPECT_TRUE(fails(self.save(), "nodes[0]: is on or below a cycle"));
    for (int i = 0; i < 3; ++i) ring.add("nodes", {{"children", {(i + 1) % 3}}});
    EXPECT_TRUE(fails(ring.save(), "nodes[0]: is on or below a cycle"));
    parents.add("nodes", {{"children", {2}}});
    parents.add("nodes", {{"children", {2}}});
    parents.add("nodes", json::object());
    EXPECT_TRUE(fails(parents.save(), "nodes[1].children[0]: nodes[2] already has a parent"));
}

TEST(GltfBadInput, AHundredThousandLevelsOfNodesAreDrawn) {
    constexpr int depth = 100000;
    GltfBuilder file;
    const size_t leaf = file.triangle();
    json& nodes = file.json["nodes"];
    for (int i = 1; i <= depth; ++i) {
        nodes.push_back(
            {{"children", {i == 1 ? leaf : nodes.size() - 1}}, {"translation", {0, 0, 0.5}}});
    }
    const Scene scene = load_gltf(file.save());
    ASSERT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.frame.leave(Vec3d(scene.meshes[0].positions[1])), Vec3d(1, 0, depth / 2.0));
}

TEST(GltfBadInput, TrianglesWithoutFinitePositionsAreDroppedWithAWarning) {
    for (const float value : {nan, infinity, -infinity}) {
        GltfBuilder file;
        file.mesh_node(
            {{"attributes",
              {{"POSITION", file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, value, 0}, "VEC3")}}},
             {"indices", file.indices({0, 1, 2, 0, 3, 1, 1, 3, 2})}});
        const Scene scene = load_gltf(file.save());
        EXPECT_EQ(scene.meshes.at(0).triangles.size(), 1u);
        EXPECT_EQ(scene.meshes[0].positions.size(), 3u);
        EXPECT_EQ(scene.bounds.max, Vec3(1, 1, 0));
        ASSERT_EQ(scene.warnings.size(), 1u);
        EXPECT_NE(scene.warnings[0].find("meshes[0].primitives[0]: 2 triangles"),
                  std::string::npos);
    }
}

TEST(GltfBadInput, NormalsAndColoursAreRepaired) {
    GltfBuilder file;
    file.mesh_node(
        {{"attributes",
          {{"POSITION", file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3")},
           {"NORMAL", file.floats({0, 0, 0, nan, 0, 1, 0, 0, 1e-30f}, "VEC3")},
           {"COLOR_0", file.floats({nan, 2, -1, 0.5, 0.5, 0.5, 0, 0, infinity}, "VEC3")}}}});
    const Mesh mesh = load_gltf(file.save()).meshes.at(0);
    for (const Vec3& n : mesh.normals) EXPECT_EQ(n, Vec3(0, 0, 1));
    EXPECT_EQ(mesh.colors[0], Vec4(0, 1, 0, 1));
    EXPECT_EQ(mesh.colors[2], Vec4(0, 0, 1, 1));
}

TEST(GltfBadInput, ZeroAreaTrianglesLoad) {
    GltfBuilder file;
    file.mesh_node({{"attributes",
                     {{"POSITION", file.floats({1, 1, 1, 1, 1, 1, 1, 1, 1}, "VEC3")},
                      {"NORMAL", file.floats({0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC3")}}}});
    const Scene scene = load_gltf(file.save());
    EXPECT_EQ(scene.bounds.min, scene.bounds.max);
    const Mesh& mesh = scene.meshes.at(0);
    ASSERT_EQ(mesh.normals.size(), 3u);
    for (const Vec3& n : mesh.normals) EXPECT_FLOAT_EQ(n.length(), 1);
}

TEST(GltfBadInput, EmptyScenesLoad) {
    for (const char* text :
         {R"({"asset":{"version":"2.0"}})",
          R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{}]})",
          R"({"asset":{"version":"2.0"},"scenes":[],"nodes":[],"meshes":[]})",
          R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[]}]})"}) {
        const Scene scene = load_gltf(write_file(test_folder() / "test.gltf", text));
        EXPECT_TRUE(scene.instances.empty());
        EXPECT_TRUE(scene.bounds.isEmpty());
    }
}

TEST(GltfBadInput, OverflowingMatricesAreErrorsAndThoseThatLeaveAPointWarnings) {
    GltfBuilder overflow;
    overflow.triangle();
    json& nodes = overflow.json["nodes"];
    for (int i = 0; i < 20; ++i) nodes.push_back({{"children", {i}}, {"scale", {1e30, 1, 1}}});
    EXPECT_TRUE(fails(overflow.save(), "its matrix to world space is not finite"));

    GltfBuilder flat;
    const size_t node = flat.triangle();
    flat.add("nodes", {{"mesh", 0}, {"scale", {0, 0, 0}}});
    flat.json["nodes"][node]["rotation"] = {0, 0, 0, 0};
    const Scene scene = load_gltf(flat.save());
    EXPECT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(scene.warnings.size(), 1u);
}

// Replaces each value within `value` in turn by values that are likely to be wrong.
void try_everywhere(json& value, const json& replacement, const std::function<void()>& test) {
    if (value.is_structured()) {
        for (auto& [key, item] : value.items()) try_everywhere(item, replacement, test);
    }
    json original = replacement;
    std::swap(original, value);
    test();
    std::swap(original, value);
}

// A file with many properties.
GltfBuilder rich_file() {
    GltfBuilder file;
    const size_t positions = file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
    const size_t times = file.floats({0, 1}, "SCALAR");
    const size_t moves = file.floats({0, 0, 0, 1, 1, 1}, "VEC3");
    const size_t joints =
        file.accessor(file.view<uint8_t>(std::vector<uint8_t>(12, 0)), 5121, "VEC4", 3);
    const size_t weights = file.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
    file.json.update(json::parse(R"({
        "extensionsUsed": ["KHR_lights_punctual", "KHR_implicit_shapes"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {}}]},
                       "KHR_implicit_shapes": {"shapes": [{"type": "sphere", "sphere": {}}]}},
        "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1],
            "baseColorTexture": {"index": 0}}, "extensions": {"KHR_materials_ior": {"ior": 2}}}],
        "textures": [{"sampler": 0}], "samplers": [{"wrapS": 10497}],
        "nodes": [{"mesh": 0, "skin": 0, "children": [2]},
                  {"camera": 0, "scale": [1, 1, 1],
                   "extensions": {"KHR_lights_punctual": {"light": 0}}},
                  {"extensions": {"SIGHTLINE_implicit_shapes": {"shape": 0, "material": 0}}}],
        "skins": [{"joints": [1]}]})"));
    file.add(
        "meshes",
        {{"weights", {0.5}},
         {"primitives",
          {{{"attributes", {{"POSITION", positions}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}}},
            {"material", 0},
            {"indices", file.indices({0, 1, 2})},
            {"targets", {{{"POSITION", positions}}}}}}}});
    file.add(
        "animations",
        {{"samplers", {{{"input", times}, {"output", moves}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}});
    return file;
}

TEST(GltfBadInput, AnyPropertyMayHaveAnyValue) {
    GltfBuilder file = rich_file();
    const auto path = test_folder() / "test.glb";
    LoadOptions options;
    options.time = 0.5f;
    write_file(path, file.glb());
    ASSERT_EQ(load_gltf(path, options).instances.size(), 2u);
    const auto can_load = [&](bool strict) {
        options.strict = strict;
        try {
            load_gltf(path, options);
            return true;
        } catch (const Error&) {
            return false;
        }
    };
    int sound = 0, drawn_with_faults = 0, refused = 0;
    for (const json& value : json::parse(
             R"([null, true, -1, 0, 1, 7, 4294967296, 1e300, 1.5, "", "x", [], {}, [[]]])")) {
        try_everywhere(file.json, value, [&] {
            write_file(path, file.glb());
            const bool strict = can_load(true), lenient = can_load(false);
            EXPECT_TRUE(lenient || !strict) << file.json;
            ++(strict ? sound : lenient ? drawn_with_faults : refused);
        });
    }
    EXPECT_GT(sound, 100);
    EXPECT_GT(drawn_with_faults, 1000);
    EXPECT_LT(refused, 100);
}

}  // namespace
}  // namespace sightline
