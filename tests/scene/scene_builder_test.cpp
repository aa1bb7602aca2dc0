#include "scene/scene_builder.h"

#include "scene/mesh_makers.h"

#include <gtest/gtest.h>

#include <map>

namespace sightline {
namespace {

const Mesh unit_square = quad_mesh({0, 0, 0}, {1, 0, 0}, {0, 1, 0});

TEST(SceneBuilder, StartsWithTheDefaultMaterial) {
    SceneBuilder builder;
    Material red;
    red.base_color_factor = {1, 0, 0, 1};
    EXPECT_EQ(builder.add_material(red), 1u);
    const Scene scene = builder.finish();
    EXPECT_EQ(scene.materials.size(), 2u);
    EXPECT_EQ(scene.materials[0].base_color_factor, Vec4(1, 1, 1, 1));
    EXPECT_TRUE(scene.bounds.isEmpty());
}

TEST(SceneBuilder, GivesAMeshItsMaterialAndAGroupKeepsItsOwn) {
    SceneBuilder builder;
    builder.add_material({});
    builder.add_material({});
    Mesh mesh = unit_square;
    EXPECT_EQ(builder.add_mesh(mesh, 2), 0u);
    mesh.material = 1;
    Shape shape;
    shape.material = 2;
    EXPECT_EQ(builder.add_group({mesh, unit_square}, {shape}), 1u);
    EXPECT_EQ(builder.add_shape(shape, 1), 2u);
    const Scene scene = builder.finish();
    EXPECT_EQ(scene.material_of(0), 2u);
    EXPECT_EQ(scene.material_of(1), 1u);
    EXPECT_EQ(scene.material_of(2), 0u);
    EXPECT_EQ(scene.material_of(3), 2u);
    EXPECT_EQ(scene.material_of(4), 1u);
    EXPECT_EQ(scene.groups[1].meshes, (std::vector<uint32_t>{1, 2}));
    EXPECT_EQ(scene.groups[1].shapes, (std::vector<uint32_t>{0}));
}

TEST(SceneBuilder, LeavesRoomForEmbreeBehindThePositions) {
    SceneBuilder builder;
    builder.add_group({unit_square, unit_square});
    for (const Mesh& mesh : builder.finish().meshes)
        EXPECT_GT(mesh.positions.capacity(), mesh.positions.size());
}

TEST(SceneBuilder, InvertsTheMatricesOfInstancesAndShapes) {
    const Mat4 mirror(-2, 0, 0, 0, 0, 4, 0, 0, 0, 0, 1, 0, 3, 5, 7, 1);
    SceneBuilder builder;
    Shape ball;
    ball.to_object.setTranslation(Vec3d(1, 2, 3));
    const uint32_t group = builder.add_shape(ball);
    builder.add_instance(group);
    builder.add_instance(group, mirror);
    const Scene scene = builder.finish();
    EXPECT_TRUE(scene.instances[0].baked);
    EXPECT_FALSE(scene.instances[0].mirrored);
    EXPECT_EQ(scene.instances[0].object_to_world, Mat4());
    EXPECT_FALSE(scene.instances[1].baked);
    EXPECT_TRUE(scene.instances[1].mirrored);
    EXPECT_EQ(scene.instances[1].object_to_world, mirror);
    EXPECT_EQ(scene.instances[1].object_to_world * scene.instances[1].world_to_object, Mat4());
    EXPECT_EQ(scene.shapes[0].to_object * scene.shapes[0].to_shape, Mat4d());
}

TEST(SceneBuilder, BoundsWhatIsDrawn) {
    Mat4 twice_as_large;
    twice_as_large.setScale(2);
    SceneBuilder builder;
    builder.add_instance(builder.add_mesh(unit_square), twice_as_large);
    builder.add_mesh(quad_mesh({0, 0, 90}, {1, 0, 0}, {0, 1, 0}));  // never drawn
    Shape ball;
    ball.to_object.setTranslation(Vec3d(0, 0, 5));
    builder.add_instance(builder.add_shape(ball));
    Shape endless;
    endless.kind = ShapeKind::plane;
    endless.size = {0, 0, 0};
    builder.add_instance(builder.add_shape(endless));
    const Box3 bounds = builder.finish().bounds;
    EXPECT_NEAR((bounds.min - Vec3(-0.5f, -0.5f, 0)).length(), 0, 1e-6);
    EXPECT_NEAR((bounds.max - Vec3(2, 2, 5.5f)).length(), 0, 1e-6);
}

TEST(MeshMakers, MakeAQuadWhoseFrontIsTheSideOfTheCrossProduct) {
    const Mesh mesh = quad_mesh({1, 1, 1}, {2, 0, 0}, {0, 3, 0});
    EXPECT_EQ(mesh.positions[2], Vec3(3, 4, 1));
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3 &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
        EXPECT_EQ(cross(q - p, r - p), Vec3(0, 0, 6));
    }
}

TEST(MeshMakers, MakeAClosedSphereThatFacesOutwards) {
    const Vec3 centre(1, 2, 3);
    const Mesh mesh = sphere_mesh(5, 7, centre, 2);
    EXPECT_EQ(mesh.triangles.size(), 2u * 7 * 4);
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (const auto& triangle : mesh.triangles) {
        const auto& [a, b, c] = triangle;
        const Vec3 &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
        EXPECT_GT(dot(cross(q - p, r - p), p - centre), 0);
        for (const auto& edge : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) ++edges[edge];
    }
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1);
        EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
    }
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
        EXPECT_NEAR(mesh.normals[i].length(), 1, 1e-6);
        EXPECT_NEAR(((mesh.positions[i] - centre) - mesh.normals[i] * 2).length(), 0, 1e-6);
    }
}

}  // namespace
}  // namespace sightline
