// The exact intersector makes the same decisions as the referee, however badly floats behave.
#include "core/error.h"
#include "exact/referee.h"
#include "intersect/engines.h"
#include "intersect/exact/hit_query.h"
#include "intersect/methods/triangle_methods.h"
#include "support/rays.h"
#include "support/scenes.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace sightline {
namespace {

Hit trace(const Intersector& engine, const Ray& ray, Visible visible = Visible::all) {
    Hit hit;
    engine.closest(std::span(&ray, 1), std::span(&hit, 1), Coherence::incoherent, visible);
    return hit;
}

bool blocks(const Intersector& engine, const Ray& ray) {
    uint8_t blocked = 2;
    engine.occluded(std::span(&ray, 1), std::span(&blocked, 1), Coherence::incoherent);
    return blocked != 0;
}

/// Expects the nearest hit, the tie-break, t and occlusion to equal the referee's; counts the hits.
int expect_truth(const Intersector& engine, const Referee& referee, const Ray& ray) {
    const Truth truth = referee.closest(ray);
    const Hit hit = trace(engine, ray);
    EXPECT_EQ(bool(hit), !truth.nearest.empty());
    EXPECT_EQ(blocks(engine, ray), !truth.nearest.empty());
    if (!hit || truth.nearest.empty()) return 0;
    EXPECT_EQ(surface_of(hit), truth.nearest.front());
    EXPECT_NEAR(static_cast<double>(hit.t), truth.t, 1e-6 * truth.t);
    return 1;
}

int expect_truth(const Scene& scene, const std::vector<Ray>& rays) {
    const auto engine = make_engine(scene, "exact");
    const Referee referee(scene);
    int hits = 0;
    for (const Ray& ray : rays) hits += expect_truth(*engine, referee, ray);
    return hits;
}

std::vector<Ray> aimed_rays(const Mesh& mesh, int count, const Vec3& middle = {0, 0, 0},
                            float spread = 0.3f) {
    TestRandom random;
    std::vector<Ray> rays;
    for (int i = 0; i < count; ++i)
        for (const Aim aim : {Aim::anywhere, Aim::edge, Aim::vertex})
            rays.push_back(aimed_ray(mesh, aim, random, middle, spread));
    return rays;
}

TEST(ExactIntersector, IsExactOnClosedMeshesFromInsideAndOutside) {
    for (const uint32_t n : {3u, 16u, 64u}) {
        const Scene scene = scene_of({globe(n)});
        const int count = 500;
        EXPECT_EQ(expect_truth(scene, aimed_rays(scene.meshes[0], count)), 3 * count);
        const auto outside = aimed_rays(scene.meshes[0], count, {5, 4, 3}, 1);
        EXPECT_GT(expect_truth(scene, outside), count);
    }
}

// SIGHTLINE_LEAK_RAYS sets their number; ten million take three minutes.
TEST(ExactIntersector, LosesNoRayAimedAtAVertexOrAnEdgeOfAClosedMesh) {
    const char* wanted = std::getenv("SIGHTLINE_LEAK_RAYS");
    const size_t count = wanted                ? std::strtoull(wanted, nullptr, 10)
                         : SIGHTLINE_SANITIZED ? 20000
                                               : 100000;
    const Scene scene = scene_of({globe(128)});
    const Mesh& mesh = scene.meshes[0];
    const auto tree = make_engine(scene, "exact");
    TestRandom random;
    std::vector<Ray> rays(4096);
    std::vector<Hit> hits(rays.size());
    size_t lost = 0;
    for (size_t done = 0; done < count; done += rays.size()) {
        for (size_t i = 0; i < rays.size(); ++i) {
            const auto& triangle = random.pick(mesh.triangles);
            const Vec3& a = mesh.positions[triangle[0]];
            const Vec3& b = mesh.positions[triangle[1]];
            const float share = i % 2 ? random.between(0, 1) : 0.0f;
            const Vec3 from = random.vector(0.3f);
            rays[i] = {from, 0, a + (b - a) * share - from};
        }
        tree->closest(rays, hits, Coherence::incoherent);
        lost += static_cast<size_t>(
            std::count_if(hits.begin(), hits.end(), [](const Hit& hit) { return !hit; }));
    }
    EXPECT_EQ(lost, 0u) << "of " << count;
}

TEST(ExactIntersector, IsExactFarFromTheOriginAndAtEveryScale) {
    for (const float offset : {1e3f, 1e6f}) {
        const Scene scene = scene_of({globe(16, offset * 0.01f, Vec3(offset))});
        const auto rays = aimed_rays(scene.meshes[0], 200, Vec3(offset), offset * 0.003f);
        EXPECT_GT(expect_truth(scene, rays), 500);
    }
    for (const float size : {1e-20f, 1e-9f, 1e9f, 1e17f}) {
        const Scene scene = scene_of({globe(8, size)});
        for (const float speed : {1e-10f, 1.0f, 1e12f}) {
            std::vector<Ray> rays = aimed_rays(scene.meshes[0], 30, {0, 0, 0}, size * 0.3f);
            for (Ray& ray : rays) ray.direction *= speed;
            EXPECT_GT(expect_truth(scene, rays), 60) << size << ' ' << speed;
        }
    }
}

/// A globe of size 2^-20, so that t is finite, away from the origin, where 0·∞ could hide errors.
Scene little_globe() { return scene_of({globe(8, 0x1p-20f, Vec3(0x1p-18f))}); }

/// Rays from inside it along directions whose reciprocals are infinite.
std::vector<Ray> denormal_rays() {
    std::vector<Ray> rays;
    for (const float x : {-3.0f, -1.0f, -0.0f, 0.0f, 2.0f})
        for (const float y : {-5.0f, 0.0f, 1.0f})
            for (const float z : {-1.0f, -0.0f, 7.0f})
                if (x != 0 || y != 0 || z != 0)
                    rays.push_back(
                        {Vec3(0x1.04p-18f, 0x1.1p-18f, 0x1.06p-18f), 0, Vec3(x, y, z) * 0x1p-130f});
    return rays;
}

/// The ball of 18 triangles, each vertex multiplied by 2^exponent and rounded.
Mesh ball_of_size(int exponent) {
    Mesh ball = globe(3);
    for (Vec3& p : ball.positions)
        for (int i = 0; i < 3; ++i) p[i] = std::ldexp(p[i], exponent);
    return ball;
}

TEST(ExactIntersector, IsExactAtEveryExponentOfAFloat) {
    int hits = 0;
    for (int exponent = -149; exponent <= 126; exponent += 5) {
        const Mesh ball = ball_of_size(exponent);
        const float size = std::ldexp(1.0f, exponent);
        TestRandom random;
        std::vector<Ray> rays;
        for (int i = 0; i < 60; ++i) {
            const Aim aim = i % 3 == 0 ? Aim::vertex : Aim::edge;
            rays.push_back(aimed_ray(ball, aim, random, {0, 0, 0}, i % 2 ? size / 4 : size));
            rays.back().direction *= i % 5 ? 1.0f : std::ldexp(1.0f, exponent / 2 < -20 ? 40 : -3);
        }
        hits += expect_truth(scene_of({ball}), rays);
    }
    EXPECT_GT(hits, 2500);
}

TEST(ExactIntersector, IsExactFromOriginsUpToTheLargestFloat) {
    const Mesh square = quad_mesh({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    Shape ball;
    ball.radius = 0.5f;
    Mat4 moved, sheared;
    moved.setTranslation(Vec3(10, 0, 0));
    sheared[0][1] = 3;
    sheared[3][0] = -10;
    SceneBuilder builder;
    builder.add_instance(builder.add_group({square}));
    const uint32_t group = builder.add_mesh(square);
    for (const Mat4& m : {moved, sheared}) builder.add_instance(group, m);
    const Scene scene = builder.finish();
    std::vector<Ray> rays;
    for (int exponent = 0; exponent <= 127; ++exponent) {
        const float far = std::ldexp(1.0f, exponent);
        for (const float x : {0.25f, 1.0f, 10.5f, -9.75f, 50.0f})
            for (const float slope : {0.0f, 0x1p-60f})
                rays.push_back({{x, 0.25f, far}, 0, {slope, 0, -1}, infinity});
    }
    EXPECT_GT(expect_truth(scene, rays), 128 * 4);
}

TEST(ExactIntersector, IsExactInInstancesOfEveryScale) {
    for (int exponent = -120; exponent <= 100; exponent += 20) {
        Mat4 scaled, squeezed;
        for (int i = 0; i < 3; ++i) scaled[i][i] = std::ldexp(1.0f, exponent);
        squeezed[0][0] = std::ldexp(1.0f, exponent / 2);
        squeezed[1][0] = 0.5f;
        squeezed[3][0] = 4;
        SceneBuilder builder;
        const Mesh ball = globe(4);
        const uint32_t group = builder.add_mesh(ball);
        builder.add_instance(group, scaled);
        builder.add_instance(group, squeezed);
        const Scene scene = builder.finish();
        TestRandom random;
        std::vector<Ray> rays;
        for (int i = 0; i < 40; ++i) {
            const Mat4& m = i % 2 ? scaled : squeezed;
            const auto& triangle = random.pick(ball.triangles);
            const Vec3 target = random.pick(ball.positions) * m;
            const Vec3 origin = (ball.positions[triangle[0]] * 0.25f) * m + random.vector(1e-3f);
            rays.push_back({origin, 0, target - origin, infinity});
        }
        expect_truth(scene, rays);
    }
}

TEST(ExactIntersector, IsExactAlongDenormalDirections) {
    const auto rays = denormal_rays();
    EXPECT_EQ(expect_truth(little_globe(), rays), static_cast<int>(rays.size()));
    // All coordinates are denormal, too.
    Mesh tiny;
    tiny.positions = {{0, 0, 0}, {0x1p-140f, 0, 0}, {0, 0x1p-140f, 0}, {0x1p-140f, 0x1p-140f, 0}};
    tiny.triangles = {{0, 1, 2}, {3, 2, 1}};
    std::vector<Ray> down;
    for (const Vec3& p : tiny.positions) down.push_back({p + Vec3(0, 0, 0x1p-140f), 0, {}});
    for (Ray& ray : down) ray.direction = {0, -0.0f, -0x1p-140f};
    EXPECT_EQ(expect_truth(scene_of({tiny}), down), 4);
}

TEST(ExactIntersector, IsExactOnGridsHitAlongTheAxes) {
    Mesh grid;
    const int n = 20;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j)
            grid.positions.push_back(
                {static_cast<float>(i) * 0.1f, static_cast<float>(j) * 0.1f, 0});
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t j = 0; j < n; ++j) {
            const uint32_t a = i * (n + 1) + j;
            grid.triangles.push_back({a, a + n + 1, a + n + 2});
            grid.triangles.push_back({a, a + n + 2, a + 1});
        }
    std::vector<Ray> rays;
    for (const Vec3& p : grid.positions)
        for (const float zero : {0.0f, -0.0f})
            rays.push_back({p + Vec3(0, 0, 1), 0, {zero, zero, -1}});
    EXPECT_EQ(expect_truth(scene_of({grid}), rays), static_cast<int>(rays.size()));
}

/// The same mesh baked, moved, sheared, mirrored, tiny and nested in itself.
TEST(ExactIntersector, IsExactForInstances) {
    Scene scene = scene_of({globe(8)});
    TestRandom random;
    for (int i = 0; i < 8; ++i) {
        Mat4 matrix;
        for (int row = 0; row < 4; ++row)
            for (int column = 0; column < 3; ++column)
                matrix[row][column] = random.between(-1, 1) * (row == 3 ? 5.0f : 1.0f);
        if (i == 6) matrix[3][0] = 1e5f;
        if (i == 7)
            for (int column = 0; column < 3; ++column)
                matrix[2][column] = matrix[1][column];  // flat
        scene.instances.push_back(make_instance(0, matrix));
    }
    std::vector<Ray> rays;
    for (int i = 0; i < 1500; ++i) {
        const Vec3 origin = random.vector(8);
        // To a vertex of some instance, as near as floats come to it.
        const Instance& instance = random.pick(scene.instances);
        const Vec3& vertex = random.pick(scene.meshes[0].positions);
        const Vec3 target =
            instance.baked ? vertex : transform_point(vertex, instance.object_to_world);
        rays.push_back({origin, 0, target - origin + random.vector(i % 2 ? 0.1f : 0)});
    }
    EXPECT_GT(expect_truth(scene, rays), 1000);
}

/// Rays touch the box of such an instance at corners of the mesh, and end there.
TEST(ExactIntersector, IsExactForInstancesThatAreLeavesOfTheirOwn) {
    Mesh corner;
    corner.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    corner.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
    SceneBuilder builder;
    const uint32_t group = builder.add_mesh(corner);
    TestRandom random;
    std::vector<Mat4> places(8);
    for (Mat4& place : places) {
        place.setAxisAngle(random.vector(1), random.between(-3, 3));
        for (int axis = 0; axis < 3; ++axis) place[3][axis] = random.between(-2, 2);
        builder.add_instance(group, place);
    }
    std::vector<Ray> rays;
    for (int i = 0; i < 6000; ++i) {
        const Vec3 target = random.pick(corner.positions) * random.pick(places);
        const Vec3 origin = random.vector(i % 2 == 0 ? 3.0f : 300.0f);
        rays.push_back({origin, 0, target - origin, i % 3 == 0 ? 1 : infinity});
    }
    EXPECT_GT(expect_truth(builder.finish(), rays), 1000);
}

TEST(ExactIntersector, DecidesTiesAndSegmentEndsExactly) {
    const Mesh mesh = globe(8);
    Scene scene = scene_of({mesh, mesh});  // every triangle twice
    std::vector<Ray> rays = aimed_rays(mesh, 50);
    EXPECT_EQ(expect_truth(scene, rays), 150);
    TestRandom random;
    const Referee referee(scene);
    for (Ray& ray : rays) {
        const double t = referee.closest(ray).t;
        (random.bits() % 2 == 0 ? ray.tfar : ray.tnear) = static_cast<float>(t);
    }
    const int hits = expect_truth(scene, rays);
    EXPECT_GT(hits, 10);
    EXPECT_LT(hits, 140);
}

TEST(ExactIntersector, FindsShapesBetweenTriangles) {
    Mesh mesh;
    mesh.positions = {{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}};
    mesh.triangles = {{0, 1, 2}};
    Shape sphere;
    const Scene scene = scene_of({mesh}, {sphere});
    const auto engine = make_engine(scene, "exact");
    EXPECT_EQ(trace(*engine, {{0, 0, 2}, 0, {0, 0, -1}}).geometry, 1u);
    EXPECT_EQ(trace(*engine, {{0, 0, 2}, 0, {0, 0, -1}}).t, 1.5f);
    EXPECT_EQ(trace(*engine, {{0, 0, 0.25f}, 0, {0, 0, -1}}).geometry, 0u);
    EXPECT_EQ(trace(*engine, {{3, 0, 2}, 0, {0, 0, -1}}).geometry, 0u);
    EXPECT_FALSE(blocks(*engine, {{0, 0, 2}, 0, {0, 0, -1}, 1.25f}));
}

TEST(ExactIntersector, IgnoresSurfacesThatAreNotVisible) {
    Material film;
    film.alpha_mode = AlphaMode::blend;
    SceneBuilder builder;
    builder.add_instance(builder.add_mesh(globe(8, 2), builder.add_material(film)));
    builder.add_instance(builder.add_mesh(globe(8, 4)));
    const Scene scene = builder.finish();
    for (const char* method : {"exact", "woop"}) {
        const auto engine = make_engine(scene, method);
        const Ray ray = {{0, 0, 0}, 0, {1, 0.3f, 0.2f}};
        EXPECT_EQ(trace(*engine, ray).geometry, 0u) << method;
        EXPECT_EQ(trace(*engine, ray, Visible::opaque).geometry, 1u) << method;
        EXPECT_EQ(trace(*engine, ray, Visible::translucent).geometry, 0u) << method;
    }
}

TEST(ExactIntersector, ToleratesBrokenInput) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0},   {1, 0, 0},     {0, 1, 0},
                      {NAN, 0, 0}, {1e30f, 0, 0}, {0, infinity, 0}};
    mesh.triangles = {{0, 1, 3}, {0, 1, 5}, {0, 4, 2}, {0, 1, 1}};
    const Scene scene = scene_of({mesh});
    EXPECT_EQ(expect_truth(scene, {{{0.125f, 0.125f, 1}, 0, {0, 0, -1}},
                                   {{1e20f, 0.125f, 1}, 0, {0, 0, -1}},
                                   {{2, 2, 1}, 0, {0, 0, -1}}}),
              2);
    const auto engine = make_engine(scene, "exact");
    for (const Ray& ray :
         {Ray{{0.1f, 0.1f, 1}, 0, {0, 0, 0}}, Ray{{NAN, 0, 1}, 0, {0, 0, -1}},
          Ray{{0.1f, 0.1f, 1}, 2, {0, 0, -1}, 1}, Ray{{0, 0, 1}, 0, {0, infinity, -1}}}) {
        EXPECT_FALSE(trace(*engine, ray));
        EXPECT_FALSE(blocks(*engine, ray));
    }
    EXPECT_FALSE(trace(*make_engine(Scene(), "exact"), {{0, 0, 1}, 0, {0, 0, -1}}));
    EXPECT_FALSE(trace(*make_engine(Scene(), "woop"), {{0, 0, 1}, 0, {0, 0, -1}}));
}

TEST(MethodIntersector, EveryStructureFindsTheSameHits) {
    const Scene scene = scene_of({globe(8), globe(8, 0.5f, {0, 2, 0})});
    TestRandom random;
    for (const TriangleMethod& method : triangle_methods()) {
        const auto tree = make_engine(scene, method.name);
        const auto bounds = make_engine(scene, method.name + ":bounds");
        const auto loop = make_engine(scene, method.name + ":loop");
        for (int i = 0; i < 100; ++i) {
            const Ray ray = aimed_ray(scene.meshes[1], Aim::anywhere, random);
            const Hit hit = trace(*loop, ray);
            EXPECT_EQ(trace(*tree, ray).t, hit.t) << method.name;
            EXPECT_EQ(trace(*bounds, ray).t, hit.t) << method.name;
        }
    }
}

/// A method may miss what underflows, but then it misses it in every structure.
TEST(MethodIntersector, EveryStructureFindsTheSameHitsAlongDenormalDirections) {
    const Scene scene = little_globe();
    for (const TriangleMethod& method : triangle_methods()) {
        const auto loop = make_engine(scene, method.name + ":loop");
        const auto tree = make_engine(scene, method.name);
        const auto bounds = make_engine(scene, method.name + ":bounds");
        for (const Ray& ray : denormal_rays()) {
            const Hit hit = trace(*loop, ray);
            EXPECT_TRUE(hit || !method.name.ends_with("-double")) << method.name;
            EXPECT_EQ(trace(*tree, ray).t, hit.t) << method.name;
            EXPECT_EQ(trace(*bounds, ray).t, hit.t) << method.name;
        }
    }
}

TEST(ExactIntersector, InterleavedTraversalFindsTheSameAsSingleRays) {
    const Scene scene = scene_of({globe(32)});
    const TwoLevelBvh bvh(scene);
    const TriangleBvh& baked = bvh.baked.triangles;
    const std::vector<Ray> rays = aimed_rays(scene.meshes[0], 50);
    std::vector<ClosestHitQuery> queries;
    std::vector<TraversalLimits> limits;
    std::vector<TraversalRay> traversal_rays;
    std::vector<TraversalJob> jobs;
    queries.reserve(rays.size());
    for (const Ray& ray : rays) {
        const ClosestHitQuery& query = queries.emplace_back(bvh, ray, Visible::all);
        limits.push_back(query.initial_limits());
        traversal_rays.emplace_back(query.world_ray(), baked.bvh, baked.max_edge);
    }
    for (size_t i = 0; i < rays.size(); ++i)
        jobs.push_back({&traversal_rays[i], &limits[i], &queries[i]});
    traverse_interleaved(baked, jobs);
    for (size_t i = 0; i < rays.size(); ++i) {
        ClosestHitQuery alone(bvh, rays[i], Visible::all);
        TraversalLimits alone_limits = alone.initial_limits();
        alone.finish(alone_limits, traverse(baked, traversal_rays[i], alone_limits, alone));
        queries[i].finish(limits[i], jobs[i].stopped);
        EXPECT_EQ(surface_of(queries[i].hit()), surface_of(alone.hit()));
        EXPECT_EQ(queries[i].hit().t, alone.hit().t);
        EXPECT_TRUE(queries[i].hit());
    }
}

TEST(Engines, UnknownMethodsAndStructuresAreErrors) {
    const Scene scene;
    EXPECT_THROW(make_engine(scene, "wooop"), Error);
    EXPECT_THROW(make_engine(scene, "woop:grid"), Error);
}

}  // namespace
}  // namespace sightline
