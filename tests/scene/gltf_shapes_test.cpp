#include "core/error.h"
#include "core/files.h"
#include "intersect/engines.h"
#include "intersect/shapes.h"
#include "scene/gltf/load.h"
#include "scene/shape_bounds.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>

#include <fstream>

namespace sightline {
namespace {

Scene load(const std::string& json) {
    const std::string path = test_folder() / "a.gltf";
    std::ofstream(path) << json;
    LoadOptions options;
    options.strict = true;
    return load_gltf(path, options);
}

/// A file with one shape and one node that refers to it, whose properties `node` overrides.
std::string file_with(const std::string& shape, const std::string& node = R"("name": "node")",
                      const std::string& placed = R"("shape": 0, "material": 1)") {
    return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "materials": [{}, {"name": "second"}],
        "extensionsUsed": ["KHR_implicit_shapes", "SIGHTLINE_implicit_shapes"],
        "extensions": {"KHR_implicit_shapes": {"shapes": [)" +
           shape + R"(]}}, "nodes": [{)" + node +
           R"(, "extensions": {"SIGHTLINE_implicit_shapes": {)" + placed + "}}}]}";
}

Shape load_shape(const std::string& shape) { return load(file_with(shape)).shapes.at(0); }

void expect_error(const std::string& json, const std::string& expected) {
    try {
        load(json);
        ADD_FAILURE() << "no error: " << expected;
    } catch (const Error& error) {
        const std::string what = error.what();
        EXPECT_EQ(what.substr(what.find(": ") + 2), expected);
    }
}

TEST(GltfShapes, AreReadWithTheirParameters) {
    const Shape sphere = load_shape(R"({"type": "sphere", "sphere": {"radius": 2}})");
    EXPECT_EQ(sphere.kind, ShapeKind::sphere);
    EXPECT_EQ(sphere.radius, 2);
    EXPECT_EQ(sphere.material, 2u);  // 0 is glTF's default
    EXPECT_EQ(sphere.name, "node");
    const Shape box = load_shape(R"({"type": "box", "box": {"size": [1, 2, 3]}})");
    EXPECT_EQ(box.kind, ShapeKind::box);
    EXPECT_EQ(box.size, Vec3(1, 2, 3));
    const Shape capsule = load_shape(R"({"type": "capsule", "capsule": {"radiusTop": 0}})");
    EXPECT_EQ(capsule.kind, ShapeKind::capsule);
    EXPECT_EQ(capsule.radius_top, 0);
    EXPECT_EQ(capsule.radius_bottom, 0.25f);
    EXPECT_EQ(capsule.height, 0.5f);
    EXPECT_EQ(load_shape(R"({"type": "cylinder"})").kind, ShapeKind::cylinder);
    const Shape plane = load_shape(R"({"type": "plane", "plane": {"sizeX": 4}})");
    EXPECT_EQ(plane.kind, ShapeKind::plane);
    EXPECT_EQ(plane.size.x, 4);
    EXPECT_LE(plane.size.z, 0);
    const Shape torus = load_shape(R"({"type": "torus", "torus": {"tubeRadius": 0.125}})");
    EXPECT_EQ(torus.kind, ShapeKind::torus);
    EXPECT_EQ(torus.radius, 0.5f);
    EXPECT_EQ(torus.tube_radius, 0.125f);
    const Shape heart = load_shape(R"({"type": "heart", "heart": {"scale": 3}})");
    EXPECT_EQ(heart.kind, ShapeKind::heart);
    EXPECT_EQ(heart.scale, 3);
}

TEST(GltfShapes, AreTransformedByTheirNode) {
    const Scene scene =
        load(file_with(R"({"type": "sphere"})", R"("translation": [0, 10, 0], "scale": [1, 4, 1])",
                       R"("shape": 0)"));
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(scene.material_of(0), 0u);
    const ShapeRoots roots = intersect_shape(scene.shape(0), {0, 0, 0}, {0, 1, 0}, 0, 1e9);
    ASSERT_EQ(roots.count, 2);
    EXPECT_NEAR(roots.t[0], 8, 1e-12);
    EXPECT_NEAR(roots.t[1], 12, 1e-12);
    EXPECT_NEAR(scene.bounds.max.y, 12, 1e-5f);
}

TEST(GltfShapes, EndlessPlanesDoNotExtendTheBounds) {
    const Scene scene = load(file_with(R"({"type": "plane"})"));
    EXPECT_EQ(scene.shapes.size(), 1u);
    EXPECT_TRUE(scene.bounds.isEmpty());
}

// Pressed along y: a disc of radius 1/2, whichever way the sphere was turned before.
TEST(GltfShapes, ScaledToAPlaneAreDrawnFlat) {
    for (const char* more : {R"("scale": [1, 0, 1])", R"("matrix": [0.6, 0, 0, 0, -0.8, 0, 0, 0,
                             0, 0, 1, 0, 3, 2, 1, 1])"}) {
        const Scene scene = load(file_with(R"({"type": "sphere"})", more));
        ASSERT_EQ(scene.shapes.size(), 1u);
        EXPECT_TRUE(scene.warnings.empty());
        const Vec3 size = scene.bounds.size(), centre = scene.bounds.center();
        EXPECT_NEAR(size.x, 1, 1e-3f);
        EXPECT_LE(size.y, 1e-3f);
        const std::vector<Ray> rays = {
            {.origin = centre + Vec3(0.25f, 5, 0.25f), .direction = {0, -1, 0}}};
        std::vector<Hit> hits(1);
        make_engine(scene, "few-shapes")->closest(rays, hits, Coherence::incoherent);
        EXPECT_NEAR(hits[0].t, 5, 1e-4f);
    }
}

TEST(GltfShapes, ScaledToALineAreDroppedWithAWarning) {
    const Scene scene = load(file_with(R"({"type": "sphere"})", R"("scale": [1, 0, 0])"));
    EXPECT_TRUE(scene.shapes.empty());
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.warnings[0], "nodes[0]: is scaled to a line or a point: not drawn");
}

TEST(GltfShapes, OfANodeWithInstancesAreRepeated) {
    const Scene scene = load(R"({"asset": {"version": "2.0"},
        "buffers": [{"byteLength": 24,
                     "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAEAAAEBA"}],
        "bufferViews": [{"buffer": 0, "byteLength": 24}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 2}],
        "extensions": {"KHR_implicit_shapes": {"shapes": [{"type": "sphere"}]}},
        "nodes": [{"translation": [10, 0, 0], "extensions": {
            "SIGHTLINE_implicit_shapes": {"shape": 0},
            "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}}]})");
    ASSERT_EQ(scene.instances.size(), 2u);
    EXPECT_EQ(shape_bounds(scene.shape(0)).center(), Vec3(10, 0, 0));
    EXPECT_EQ(shape_bounds(scene.shape(1)).center(), Vec3(11, 2, 3));
}

TEST(GltfShapes, OutOfRangeAreDroppedWithAWarning) {
    const Scene scene = load(file_with(R"({"type": "sphere"})", R"("scale": [1e20, 1, 1])"));
    EXPECT_TRUE(scene.shapes.empty());
    EXPECT_TRUE(scene.bounds.isEmpty());
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.warnings[0], "nodes[0]: is too large or too far away: not drawn");
}

TEST(GltfShapes, ThatEmitAreReportedOnceForEachNode) {
    const auto with_material = [](const std::string& properties) {
        std::string json = file_with(R"({"type": "sphere"})");
        const std::string second = R"("name": "second")";
        return load(json.replace(json.find(second), second.size(), properties)).warnings;
    };
    const auto warnings = with_material(R"("emissiveFactor": [0, 1, 0])");
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0],
              "nodes[0]: an emissive shape shines, but diffuse surfaces do not get its light: "
              "use a mesh");
    EXPECT_TRUE(with_material(R"("emissiveFactor": [0, 0, 0])").empty());
    EXPECT_TRUE(with_material(R"("emissiveFactor": [0, 1, 0],
                                 "extensions": {"KHR_materials_unlit": {}})")
                    .empty());
}

TEST(GltfShapes, ErrorsNameTheirPlace) {
    const std::string place = "extensions.KHR_implicit_shapes.shapes[0].";
    expect_error(file_with(R"({"type": "sphere", "sphere": {"radius": 0}})"),
                 place + "sphere.radius: is not above 0");
    expect_error(file_with(R"({"type": "box", "box": {"size": [1, -1, 1]}})"),
                 place + "box.size: is not above 0");
    expect_error(file_with(R"({"type": "box", "box": {"size": [1, 1]}})"),
                 place + "box.size: has 2 numbers, not 3");
    expect_error(
        file_with(R"({"type": "cylinder", "cylinder": {"radiusTop": 0, "radiusBottom": 0}})"),
        place + "cylinder.radiusTop: and radiusBottom are both 0");
    expect_error(file_with(R"({"type": "torus", "torus": {"tubeRadius": 0.6}})"),
                 place + "torus.tubeRadius: is above radius");
    expect_error(file_with(R"({"type": "convex"})"), place + "type: \"convex\" is not supported");
    const std::string node = "nodes[0].extensions.SIGHTLINE_implicit_shapes.";
    expect_error(file_with(R"({"type": "sphere"})", R"("name": "a")", R"("shape": 1)"),
                 node + "shape: 1 is out of range: there are 1 shapes");
    expect_error(file_with(R"({"type": "sphere"})", R"("name": "a")", R"("material": 1)"),
                 node + "shape: is missing");
}

TEST(GltfShapes, TheManualsExampleLoads) {
    const auto bytes = read_file(SIGHTLINE_SOURCE_DIR "/docs/shapes.md", 1 << 20);
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const size_t begin = text.find("```json") + 7, end = text.find("```", begin);
    const Scene scene = load(text.substr(begin, end - begin));
    ASSERT_EQ(scene.shapes.size(), 3u);
    EXPECT_EQ(scene.shapes[2].kind, ShapeKind::torus);
    EXPECT_EQ(scene.materials[scene.shapes[2].material].name, "glass");
    EXPECT_NEAR(scene.bounds.max.y, 1.4f, 1e-5f);  // the egg's top
    EXPECT_TRUE(scene.warnings.empty());
}

}  // namespace
}  // namespace sightline
