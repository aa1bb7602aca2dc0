#include "intersect/few_shapes.h"

#include "intersect/embree/embree.h"
#include "support/rays.h"
#include "support/scenes.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

Shape sphere(float radius, const Vec3d& centre) {
    Shape shape;
    shape.radius = radius;
    shape.to_object.setTranslation(centre);
    return shape;
}

Shape plane(float x, float z, const Vec3d& centre) {
    Shape shape;
    shape.kind = ShapeKind::plane;
    shape.size = {x, 0, z};
    shape.to_object.setTranslation(centre);
    return shape;
}

TEST(FewShapes, FindsEachKindAtTheComputedDistance) {
    SceneBuilder builder;
    builder.add_instance(builder.add_mesh(triangle_mesh(3)));
    builder.add_instance(builder.add_shape(sphere(2, {20, 0, 0})));
    builder.add_instance(builder.add_shape(plane(4, 2, {0, -5, 0})));
    builder.add_instance(builder.add_shape(plane(0, 0, {0, -8, 0})));
    const Scene scene = builder.finish();
    const auto engine = make_few_shapes(scene);
    ASSERT_TRUE(engine);
    const auto hits = closest(*engine, {{{1, 2, 9}, 0, {0, 0, -2}, infinity},
                                        {{20, 10, 0}, 0, {0, -2, 0}, infinity},
                                        {{20, 0, 0}, 0, {0, 0, 0.5f}, infinity},
                                        {{1.9f, 0, 0.9f}, 0, {0, -1, 0}, infinity},
                                        {{1.9f, 0, 1.1f}, 0, {0, -1, 0}, infinity},
                                        {{1e7f, 0, 0}, 0, {0, -1, 0}, infinity},
                                        {{-3, 0, 0}, 0, {0, 1, 0}, infinity}});
    EXPECT_FLOAT_EQ(hits[0].t, 3);
    EXPECT_FLOAT_EQ(hits[0].u, 0.25f);
    EXPECT_FLOAT_EQ(hits[0].v, 0.5f);
    const float distances[] = {3, 4, 4, 5, 8, 8, infinity};
    const uint32_t geometries[] = {0, 1, 1, 2, 3, 3, none};
    for (size_t i = 0; i < hits.size(); ++i) {
        EXPECT_FLOAT_EQ(hits[i].t, distances[i]) << i;
        EXPECT_EQ(hits[i].geometry, geometries[i]) << i;
        EXPECT_EQ(hits[i].instance, geometries[i]) << i;
    }
}

TEST(FewShapes, AgreesWithEmbreeOnEveryRayOfAMixedScene) {
    Mesh floor;
    floor.positions = {{-7, 0, -18}, {5, 0, -18}, {5, 0, 6}, {-7, 0, 6}};
    floor.triangles = {{0, 2, 1}, {0, 3, 2}};
    Mat4 squashed;
    squashed.setTranslation(Vec3(-2, 1, -3));
    squashed[0][0] = -2;
    squashed[1][1] = 0.5f;
    SceneBuilder builder;
    builder.add_instance(builder.add_mesh(floor));
    const uint32_t ball = builder.add_shape(sphere(1.2f, {0.5, 1.5, 0}));
    builder.add_instance(ball, Mat4());
    builder.add_instance(ball, squashed);
    builder.add_instance(builder.add_shape(plane(3, 2, {0, 4, 0})));
    const Scene scene = builder.finish();
    const auto few = make_few_shapes(scene);
    const auto embree = make_embree(scene);
    ASSERT_TRUE(few);
    std::mt19937 random(3);
    std::vector<Ray> rays(20001);
    for (Ray& ray : rays)
        ray = {random_point(random) * 4 + Vec3(0, 3, 0), 0, random_point(random), infinity};
    const auto mine = closest(*few, rays);
    const auto theirs = closest(*embree, rays);
    EXPECT_EQ(occluded(*few, rays), occluded(*embree, rays));
    for (size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(mine[i].geometry, theirs[i].geometry) << i;
        ASSERT_EQ(mine[i].instance, theirs[i].instance) << i;
        if (!mine[i]) continue;
        ASSERT_NEAR(mine[i].t, theirs[i].t, 2e-5f * (1 + theirs[i].t)) << i;
        ASSERT_NEAR(mine[i].u, theirs[i].u, 1e-5f) << i;
        ASSERT_NEAR(mine[i].v, theirs[i].v, 1e-5f) << i;
    }
}

TEST(FewShapes, RespectsTheSegmentAndIgnoresInvalidRays) {
    const Scene scene = scene_of({}, {sphere(1, {0, 0, 0})});
    const auto engine = make_few_shapes(scene);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<Ray> rays = {
        {{0, 0, 3}, 2, {0, 0, -1}, infinity},   {{0, 0, 3}, 2, {0, 0, -1}, 3.9f},
        {{0, 0, 3}, 0, {0, 0, -1}, 2},          {{0, 0, 3}, 0, {0, 0, -1}, 1.9f},
        {{0, 0, nan}, 0, {0, 0, -1}, infinity}, {{0, 0, 3}, 0, {0, 0, 0}, infinity},
        {{0, 0, 3}, -1, {0, 0, -1}, infinity}};
    EXPECT_EQ(occluded(*engine, rays), (std::vector<uint8_t>{1, 0, 1, 0, 0, 0, 0}));
    EXPECT_FLOAT_EQ(closest(*engine, rays)[0].t, 4);
}

TEST(FewShapes, AClosedMeshDoesNotLeakAtItsEdges) {
    Mesh octahedron;
    octahedron.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    octahedron.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                            {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    const Scene scene = scene_of({octahedron});
    const auto engine = make_few_shapes(scene);
    std::mt19937 random(5);
    std::vector<Ray> rays(50000);
    for (Ray& ray : rays) {
        const auto& [a, b, c] = octahedron.triangles[random() % 8];
        const float s = static_cast<float>(random() % 1000) / 1000;
        const Vec3 target = octahedron.positions[a] * s + octahedron.positions[b] * (1 - s);
        ray = {random_point(random) * 0.25f, 0, {0, 0, 0}, infinity};
        ray.direction = target - ray.origin;
    }
    EXPECT_EQ(occluded(*engine, rays), std::vector<uint8_t>(rays.size(), 1));
}

TEST(FewShapes, ARayExactlyOnASharedEdgeHits) {
    const Scene scene = scene_of({quad_mesh({0, 0, 0}, {1, 0, 0}, {0, 1, 0})});
    const auto engine = make_few_shapes(scene);
    EXPECT_EQ(occluded(*engine, {{{0.5f, 0.5f, 1}, 0, {0, 0, -1}, infinity},
                                 {{0.25f, 0.25f, -1}, 0, {0, 0, 1}, infinity},
                                 {{1, 1, 1}, 0, {0, 0, -1}, infinity}}),
              (std::vector<uint8_t>{1, 1, 1}));
}

TEST(FewShapes, MasksSeparateOpaqueFromTranslucent) {
    Material film;
    film.alpha_mode = AlphaMode::blend;
    SceneBuilder builder;
    const uint32_t translucent = builder.add_material(film);
    builder.add_instance(builder.add_shape(sphere(1, {0, 0, 0}), translucent));
    builder.add_instance(builder.add_shape(sphere(1, {0, 0, -5})));
    const Scene scene = builder.finish();
    const auto engine = make_few_shapes(scene);
    const std::vector<Ray> rays = {{{0, 0, 3}, 0, {0, 0, -1}, infinity}};
    EXPECT_FLOAT_EQ(closest(*engine, rays, Coherence::coherent, Visible::all)[0].t, 2);
    EXPECT_FLOAT_EQ(closest(*engine, rays, Coherence::coherent, Visible::opaque)[0].t, 7);
    EXPECT_FLOAT_EQ(closest(*engine, rays, Coherence::coherent, Visible::translucent)[0].t, 2);
}

TEST(FewShapes, OtherScenesAreNotSupported) {
    EXPECT_FALSE(has_few_shapes(scene_of({sphere_mesh(4, 4)})));
    Shape torus;
    torus.kind = ShapeKind::torus;
    EXPECT_FALSE(has_few_shapes(scene_of({}, {torus})));
    EXPECT_TRUE(has_few_shapes(scene_of({}, {8, sphere(1, {0, 0, 0})})));
    EXPECT_FALSE(has_few_shapes(scene_of({}, {9, sphere(1, {0, 0, 0})})));
    const Scene nothing = empty_scene();
    EXPECT_FALSE(closest(*make_few_shapes(nothing), {{{0, 0, 0}, 0, {0, 0, 1}, infinity}})[0]);
}

}  // namespace
}  // namespace sightline
