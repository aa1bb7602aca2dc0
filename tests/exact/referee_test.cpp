// The referee on whole scenes, against exhaustive search and known answers; and its speed.
#include "exact/referee.h"
#include "exact/shapes.h"
#include "exact/triangle.h"
#include "support/rays.h"
#include "support/scenes.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <random>

namespace sightline {
namespace {

TEST(Referee, ReportsAllTrianglesOfASharedEdge) {
    Mesh square;
    square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    square.triangles = {{0, 1, 2}, {0, 2, 3}};
    const Scene scene = scene_of({square});
    const Referee referee(scene);
    const Truth truth = referee.closest({{0.5f, 0.5f, 2}, 0, {0, 0, -1}, infinity});
    EXPECT_EQ(truth.nearest, (std::vector<SurfaceId>{{0, 0, 0}, {0, 0, 1}}));
    EXPECT_EQ(truth.t, 2);
    EXPECT_TRUE(referee.closest({{0.5f, 1.5f, 2}, 0, {0, 0, -1}, infinity}).nearest.empty());
    EXPECT_TRUE(referee.occluded({{0.5f, 0.5f, 2}, 0, {0, 0, -1}, 2}));
    EXPECT_FALSE(referee.occluded({{0.5f, 0.5f, 2}, 0, {0, 0, -1}, 1.5f}));
}

TEST(Referee, JudgesEachKindOfAnswer) {
    Mesh square;
    square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    square.triangles = {{0, 1, 2}, {0, 2, 3}};
    const Scene scene = scene_of({square});
    const Referee referee(scene);
    const Ray inside = {{0.75f, 0.25f, 2}, 0, {0, 0, -1}, infinity},
              edge = {{0.5f, 0.5f, 2}, 0, {0, 0, -1}, infinity};
    const Ray outside = {{2, 0, 2}, 0, {0, 0, -1}, infinity};
    const Ray grazing = {{std::nextafter(1.0f, 2.0f), 0.5f, 2}, 0, {0, 0, -1}, infinity};
    const Hit first{2, 0.5f, 0.25f, 0, 0, 0}, second{2, 0.5f, 0, 1, 0, 0};
    EXPECT_EQ(referee.judge(inside, first), Verdict::same);
    EXPECT_EQ(referee.judge(edge, second), Verdict::tie);
    EXPECT_EQ(referee.judge(inside, {}), Verdict::missed);
    EXPECT_EQ(referee.judge(edge, {}), Verdict::missed);  // no neighbouring ray escapes
    EXPECT_EQ(referee.judge(outside, first), Verdict::false_hit);
    EXPECT_EQ(referee.judge(inside, second), Verdict::wrong_primitive);
    EXPECT_EQ(referee.judge(grazing, {2, 0.5f, 0.5f, 0, 0, 0}), Verdict::undecidable);
    EXPECT_EQ(referee.judge(grazing, first), Verdict::false_hit);  // no neighbour hits it there
    EXPECT_EQ(referee.judge(inside, {2.0001f, 0.5f, 0.25f, 0, 0, 0}), Verdict::wrong_t);
    EXPECT_EQ(referee.judge(inside, {2, 0.5001f, 0.25f, 0, 0, 0}), Verdict::wrong_uv);
    EXPECT_EQ(referee.judge(outside, {}), Verdict::same);
    // t is 2^140, which no float can hold.
    const Ray slow = {{0.75f, 0.25f, 0x1p100f}, 0, {0, 0, -0x1p-40f}, infinity};
    EXPECT_EQ(referee.judge(slow, {infinity, 0.5f, 0.25f, 0, 0, 0}), Verdict::same);
    EXPECT_EQ(referee.judge(slow, {0x1p127f, 0.5f, 0.25f, 0, 0, 0}), Verdict::wrong_t);
}

TEST(Referee, CallsSurfacesWithinAnUlpOfTheClosestNearTies) {
    Mesh layers;
    const float behind = std::nextafter(-0x1p-25f, -1.0f);
    for (const float z : {0.0f, behind, -0.5f})
        for (const Vec3& p : {Vec3(-1, -1, z), Vec3(1, -1, z), Vec3(0, 1, z)})
            layers.positions.push_back(p);
    layers.triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
    const Scene scene = scene_of({layers});
    const Referee referee(scene);
    const Ray ray = {{0, 0, 1}, 0, {0, 0, -1}, infinity};
    EXPECT_EQ(referee.judge(ray, {1, 0.25f, 0.5f, 0, 0, 0}), Verdict::same);
    EXPECT_EQ(referee.judge(ray, {1, 0.25f, 0.5f, 1, 0, 0}), Verdict::near_tie);
    EXPECT_EQ(referee.judge(ray, {1.5f, 0.25f, 0.5f, 2, 0, 0}), Verdict::wrong_primitive);
    const Ray before = {{0, 0, -0.25f}, 0, {0, 0, -1}, infinity};
    EXPECT_EQ(referee.judge(before, {0.25f, 0.25f, 0.5f, 0, 0, 0}), Verdict::wrong_primitive);
}

TEST(Referee, JudgesOcclusion) {
    const Scene scene = scene_of({globe(4)});
    const Referee referee(scene);
    const auto judge = [&](const Ray& ray, bool occluded) {
        return referee.judge_occlusion(ray, referee.closest(ray), occluded);
    };
    const Ray through = {{0.1f, 0.2f, 3}, 0, {0, 0, -1}, infinity};
    const Ray beside = {{3, 0, 3}, 0, {0, 0, -1}, infinity};
    EXPECT_EQ(judge(through, true), Verdict::same);
    EXPECT_EQ(judge(through, false), Verdict::missed);
    EXPECT_EQ(judge(beside, false), Verdict::same);
    EXPECT_EQ(judge(beside, true), Verdict::false_hit);
    Mesh edge;
    edge.positions = {{0, -1, 0}, {1, -1, 0}, {0, 1, 0}};
    edge.triangles = {{0, 1, 2}};
    const Scene one = scene_of({edge});
    const Referee close(one);
    const Ray grazing = {{0, 0, 1}, 0, {0, 0, -1}, infinity};
    EXPECT_EQ(close.judge_occlusion(grazing, close.closest(grazing), false), Verdict::undecidable);
}

TEST(Referee, OrdersTrianglesAgainstShapesExactly) {
    // A unit sphere's front lies at z = 1; so does the triangle, until it is moved by one ulp.
    Mesh mesh;
    mesh.positions = {{-1, -1, 1}, {1, -1, 1}, {0, 2, 1}};
    mesh.triangles = {{0, 1, 2}};
    Shape sphere;
    sphere.radius = 1;
    const Ray ray = {{0, 0, 3}, 0, {0, 0, -1}, infinity};
    Scene scene = scene_of({mesh}, {sphere});
    EXPECT_EQ(Referee(scene).closest(ray).nearest.size(), 2u);
    for (Vec3& p : scene.meshes[0].positions) p.z = std::nextafter(1.0f, 2.0f);
    EXPECT_EQ(Referee(scene).closest(ray).nearest, (std::vector<SurfaceId>{{0, 0, 0}}));
    const auto all = Referee(scene).all(ray);
    ASSERT_EQ(all.size(), 3u);
    EXPECT_EQ(all[1].surface.geometry, 1u);
    EXPECT_EQ(all[2].t, 4);
}

TEST(Referee, ClosedMeshesLoseNoRaysAimedAtVertices) {
    const Scene scene = scene_of({globe(16)});
    const Referee referee(scene);
    for (const Vec3& vertex : scene.meshes[0].positions) {
        const Ray ray = {
            {0.125f, 0.25f, -0.0625f}, 0, vertex - Vec3(0.125f, 0.25f, -0.0625f), infinity};
        EXPECT_FALSE(referee.closest(ray).nearest.empty());
        EXPECT_EQ(referee.judge(ray, {}), Verdict::missed);
    }
}

TEST(Referee, BvhAgreesWithExhaustiveSearchEvenForInstances) {
    Scene scene = scene_of({globe(6)});
    Mat4 matrix;
    matrix[0][0] = 0.3f;
    matrix[1][0] = 0.7f;
    matrix[3][0] = 0.9f;
    scene.instances.push_back(make_instance(0, matrix));
    const Referee referee(scene);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> number(-2, 2);
    int hits = 0;
    for (int i = 0; i < 1000; ++i) {
        const Ray ray = {{number(random), number(random), number(random)},
                         0,
                         {number(random), number(random), number(random)},
                         infinity};
        size_t expected = 0;
        for (const Instance& instance : scene.instances)
            for (const auto& corner : scene.meshes[0].triangles) {
                const auto& p = scene.meshes[0].positions;
                const InstancedTriangle triangle = {
                    p[corner[0]], p[corner[1]], p[corner[2]],
                    instance.baked ? nullptr : &instance.object_to_world};
                expected += exact_crossing(ray, triangle) == Crossing::hit;
            }
        const auto all = referee.all(ray);
        EXPECT_EQ(all.size(), expected);
        const Truth truth = referee.closest(ray);
        EXPECT_EQ(truth.nearest.empty(), all.empty());
        if (!all.empty()) {
            EXPECT_EQ(truth.t, all[0].t);
        }
        EXPECT_EQ(referee.occluded(ray), !all.empty());
        hits += !all.empty();
    }
    EXPECT_GT(hits, 150);
}

/// A shape of each kind, its sizes drawn at random, rotated, moved and scaled unevenly.
std::vector<Shape> random_shapes(std::mt19937& random) {
    std::uniform_real_distribution<float> size(0.1f, 1), place(-1, 1);
    std::vector<Shape> shapes;
    for (const ShapeKind kind :
         {ShapeKind::sphere, ShapeKind::plane, ShapeKind::box, ShapeKind::capsule,
          ShapeKind::cylinder, ShapeKind::torus, ShapeKind::heart}) {
        Shape shape;
        shape.kind = kind;
        shape.radius = shape.scale = size(random);
        shape.tube_radius = shape.radius * 0.4f;
        shape.size = {size(random), size(random), size(random)};
        shape.height = size(random);
        shape.radius_top = size(random);
        shape.radius_bottom = size(random);
        Mat4d& m = shape.to_object;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 3; ++j) m[i][j] = static_cast<double>(place(random));
        shape.to_shape = m.inverse();
        shapes.push_back(shape);
    }
    return shapes;
}

TEST(Referee, BvhAgreesWithExhaustiveSearchOfShapes) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> number(-2, 2);
    std::vector<Shape> shapes;
    for (int i = 0; i < 4; ++i)
        for (const Shape& shape : random_shapes(random)) shapes.push_back(shape);
    Scene scene = scene_of({}, shapes);
    Mat4 sheared;
    sheared[0][1] = 0.75f;
    sheared[2][2] = -1e-3f;
    sheared[3][0] = 5;
    scene.instances.push_back(make_instance(0, sheared));
    const Referee referee(scene);
    size_t hits = 0;
    for (int i = 0; i < 100; ++i) {
        // Aimed near the centre of a shape.
        const Shape& target = scene.shapes[static_cast<size_t>(i) % scene.shapes.size()];
        Vec3d centre = target.to_object.translation();
        if (i % 3 == 0) centre = centre * Mat4d(sheared);
        const Vec3 origin(number(random), number(random), number(random));
        const Vec3 aim(number(random), number(random), number(random));
        const Ray ray = {origin, 0, Vec3(centre) + aim * 0.1f - origin, infinity};
        std::vector<double> expected, found;
        for (const Instance& instance : scene.instances)
            for (const Shape& shape : scene.shapes) {
                const auto roots = exact_roots(
                    ray, {&shape, instance.baked ? nullptr : &instance.object_to_world});
                for (const ExactRoot& root : *roots) expected.push_back(root.t);
            }
        for (const ExactCrossing& crossing : referee.all(ray)) found.push_back(crossing.t);
        std::ranges::sort(expected);
        EXPECT_EQ(found, expected) << i;
        EXPECT_EQ(referee.closest(ray).nearest.empty(), expected.empty());
        hits += expected.size();
    }
    EXPECT_GT(hits, 80u);
}

TEST(Referee, FindsShapesOfEverySizeAtEveryPlace) {
    // Rays along an axis through the centre, where the box of a sphere is as wide as the sphere.
    for (const int exponent : {-140, -100, -30, 0, 30, 100})
        for (const float place : {0.0f, 1.0f, -3e7f}) {
            Shape sphere;
            sphere.radius = std::ldexp(1.0f, exponent);
            const double at = static_cast<double>(place) * std::ldexp(1.0, exponent);
            sphere.to_object.setTranslation(Vec3d(at, 0, 0));
            sphere.to_shape = sphere.to_object.inverse();
            const Scene scene = scene_of({}, {sphere});
            const auto x = static_cast<float>(at);
            const Ray touching = {{x, sphere.radius, 4 * sphere.radius}, 0, {0, 0, -1}, infinity};
            EXPECT_EQ(Referee(scene).all(touching).size(), 1u) << exponent << ' ' << place;
        }
}

/// 1,000 small spheres in a cube.
Scene many_spheres() {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> place(-1, 1);
    std::vector<Shape> spheres(1000);
    for (Shape& sphere : spheres) {
        sphere.radius = 0.06f;
        sphere.to_object.setTranslation(Vec3d(place(random), place(random), place(random)));
        sphere.to_shape = sphere.to_object.inverse();
    }
    return scene_of({}, spheres);
}

TEST(Referee, IsFastEnoughForAThousandShapes) {
    const Scene scene = many_spheres();
    const Referee referee(scene);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> number(-1, 1);
    const int rays = 2000;
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < rays; ++i)
        referee.closest({{number(random), number(random), 3},
                         0,
                         {number(random) * 0.2f, number(random) * 0.2f, -1},
                         infinity});
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    RecordProperty("microseconds_per_ray", static_cast<int>(1e6 * spent.count() / rays));
    EXPECT_LT(spent.count() / rays, 1e-3);  // measured: 25 µs; 21 ms without a tree
}

TEST(Referee, BrokenInputHitsNothing) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0},   {1, 0, 0},     {0, 1, 0},
                      {NAN, 0, 0}, {1e30f, 0, 0}, {0, infinity, 0}};
    mesh.triangles = {{0, 1, 3}, {0, 1, 5}, {0, 4, 2}};
    const Scene scene = scene_of({mesh});
    const Referee referee(scene);
    EXPECT_TRUE(referee.closest({{0, 0, 1}, 0, {0, 0, 0}, infinity}).nearest.empty());
    EXPECT_TRUE(referee.closest({{NAN, 0, 1}, 0, {0, 0, -1}, infinity}).nearest.empty());
    EXPECT_TRUE(referee.closest({{0, 0, 1}, 2, {0, 0, -1}, 1}).nearest.empty());
    const Truth huge = referee.closest({{1e20f, 0.125f, 1}, 0, {0, 0, -1}, infinity});
    EXPECT_EQ(huge.nearest, (std::vector<SurfaceId>{{0, 0, 2}}));
    EXPECT_TRUE(Referee(Scene()).closest({{0, 0, 1}, 0, {0, 0, -1}, infinity}).nearest.empty());
}

/// Bytes that the program has allocated.
size_t allocated() {
    const struct mallinfo2 use = mallinfo2();
    return use.uordblks + use.hblkhd;
}

TEST(Referee, NeedsNoMoreMemoryThanTheSceneHasTriangles) {
    if (SIGHTLINE_SANITIZED) GTEST_SKIP() << "sanitizers allocate by themselves";
    SceneBuilder builder;
    builder.add_instance(builder.add_group({globe(200)}));  // 80,000 triangles
    const uint32_t group = builder.add_mesh(globe(50));     // 5,000, a hundred times
    for (int i = 0; i < 100; ++i) {
        Mat4 place;
        place.translate(Vec3(static_cast<float>(i), 0, 0));
        builder.add_instance(group, place);
    }
    const Scene scene = builder.finish();
    const size_t before = allocated();
    const Referee referee(scene);
    EXPECT_LT(allocated() - before, 85000 * 16);  // 12 of each triangle; Embree's tree takes 66
}

TEST(Referee, IsFastEnoughForMillionsOfRays) {
    const Scene scene = scene_of({globe(160)});  // 51,200 triangles
    const Referee referee(scene);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> number(-1, 1);
    const int rays = 5000;
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < rays; ++i)
        referee.closest({{number(random), number(random), number(random)},
                         0,
                         {number(random), number(random), number(random)},
                         infinity});
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    RecordProperty("rays_per_second", static_cast<int>(rays / spent.count()));
    EXPECT_LT(spent.count(), 5);  // measured: 0.05 s
}

}  // namespace
}  // namespace sightline
