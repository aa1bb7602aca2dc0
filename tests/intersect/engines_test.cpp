// The engines by name.
#include "intersect/engines.h"

#include "core/error.h"
#include "intersect/timed_intersector.h"
#include "support/rays.h"
#include "support/scenes.h"

#include <gtest/gtest.h>

#include <set>

namespace sightline {
namespace {

TEST(Engines, EachNameMakesAnEngineThatHitsTheScene) {
    const Scene scene = scene_of({globe(6)});
    const Scene few = scene_of({}, {Shape{}});
    const Ray ray = {{0.1f, 0.2f, 3}, 0, {0, 0, -1}};
    for (const std::string& name : engine_names()) {
        const Scene& supported = name == "few-shapes" ? few : scene;
        const auto engine = make_engine(supported, name);
        Hit hit;
        uint8_t blocked = 0;
        engine->closest({&ray, 1}, {&hit, 1}, Coherence::coherent);
        engine->occluded({&ray, 1}, {&blocked, 1}, Coherence::incoherent);
        EXPECT_TRUE(hit) << name;
        EXPECT_EQ(blocked, 1) << name;
    }
}

TEST(Engines, EmbreeFindsTheSameHitsWithSingleRaysAndPackets) {
    const Scene scene = scene_of({globe(24)});
    TestRandom random;
    std::vector<Ray> rays;
    for (int i = 0; i < 1000; ++i) rays.push_back({random.vector(2), 0, random.vector(1)});
    rays.push_back({{0, 0, 0}, 0, {0, 0, 0}});
    rays.push_back({{NAN, 0, 0}, 0, {0, 0, 1}});
    rays.push_back({{0.1f, 0.2f, 1e20f}, 0, {0, 0, -1}});
    rays.push_back({{0.1f, 0.2f, 3}, 0, {0, 0, -1e-30f}});
    std::vector<Hit> wide(rays.size()), lone(rays.size());
    std::vector<uint8_t> wide_blocked(rays.size()), lone_blocked(rays.size());
    const auto packets = make_engine(scene, "embree");
    const auto singly = make_engine(scene, "embree-single");
    packets->closest(rays, wide, Coherence::incoherent);
    singly->closest(rays, lone, Coherence::incoherent);
    packets->occluded(rays, wide_blocked, Coherence::incoherent);
    singly->occluded(rays, lone_blocked, Coherence::incoherent);
    for (size_t i = 0; i < rays.size(); ++i) {
        EXPECT_EQ(wide[i].geometry, lone[i].geometry) << i;
        EXPECT_EQ(wide[i].primitive, lone[i].primitive) << i;
        EXPECT_EQ(bool(lone[i]), lone_blocked[i] == 1) << i;
    }
    EXPECT_EQ(wide_blocked, lone_blocked);
    EXPECT_NE(packets->description(), singly->description());
}

TEST(Engines, OneWithAClockGivesTheSameAnswersAndTheTimeOfItsCalls) {
    const Scene scene = scene_of({globe(24)});
    const auto engine = make_engine(scene, "embree");
    const TimedIntersector timed(*engine);
    EXPECT_EQ(timed.thread_seconds(), 0);
    std::vector<Ray> rays;
    for (int i = 0; i < 1000; ++i)
        rays.push_back({{0.001f * static_cast<float>(i), 0.2f, 3}, 0, {0, 0, -1}});
    std::vector<Hit> hits(rays.size()), expected(rays.size());
    std::vector<uint8_t> blocked(rays.size()), expected_blocked(rays.size());
    std::vector<RayHit> all, expected_all;
    engine->closest(rays, expected, Coherence::coherent);
    engine->occluded(rays, expected_blocked, Coherence::coherent);
    engine->all(rays, expected_all);
    double before = 0;
    const auto expect_more_time = [&](const char* call) {
        EXPECT_GT(timed.thread_seconds(), before) << call;
        before = timed.thread_seconds();
    };
    timed.closest(rays, hits, Coherence::coherent, Visible::all);
    expect_more_time("closest");
    timed.occluded(rays, blocked, Coherence::coherent, Visible::all);
    expect_more_time("occluded");
    timed.all(rays, all, Visible::all);
    expect_more_time("all");
    for (size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(hits[i].t, expected[i].t) << i;
    EXPECT_EQ(blocked, expected_blocked);
    EXPECT_EQ(all.size(), expected_all.size());
    EXPECT_EQ(timed.description(), engine->description());
    EXPECT_EQ(timed.memory(), engine->memory());
}

TEST(Engines, FindAllThatIsNearby) {
    SceneBuilder builder;
    builder.add_instance(builder.add_mesh(globe(12)));
    const uint32_t part = builder.add_mesh(globe(12, 0.3f));
    for (const float x : {0.5f, 0.9f, 1.3f}) {
        Mat4 placed;
        placed.setTranslation(Vec3(x, 0.1f, 0));
        builder.add_instance(part, placed);
    }
    const Scene scene = builder.finish();
    const auto engine = make_engine(scene, "embree");
    const Vec3 centre(0.9f, 0.2f, 0.1f);
    std::vector<SurfaceId> found;
    ASSERT_TRUE(engine->nearby(centre, 0.3f, 10000, found));
    const std::set<SurfaceId> ids(found.begin(), found.end());
    size_t total = 0;
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
        for (const uint32_t m : scene.groups[scene.instances[i].group].meshes) {
            const Mesh& mesh = scene.meshes[m];
            total += mesh.triangles.size();
            for (uint32_t k = 0; k < mesh.triangles.size(); ++k) {
                const Vec3 corner = transform_point(mesh.positions[mesh.triangles[k][0]],
                                                    scene.instances[i].object_to_world);
                const bool is_near = (corner - centre).length() < 0.3f;
                EXPECT_TRUE(!is_near || ids.contains({i, m, k})) << i << ' ' << k;
            }
        }
    EXPECT_GT(ids.size(), 50u);
    EXPECT_LT(ids.size(), total / 2);
    found.clear();
    EXPECT_FALSE(engine->nearby(centre, 0.3f, 20, found));
    EXPECT_FALSE(make_engine(scene, "exact")->nearby(centre, 0.3f, 10000, found));
}

TEST(Engines, ASuffixPinsTheCoherence) {
    const Scene scene = scene_of({globe(4)});
    EXPECT_EQ(pinned_coherence("embree"), std::nullopt);
    EXPECT_EQ(pinned_coherence("embree@coherent"), Coherence::coherent);
    EXPECT_EQ(pinned_coherence("moller-trumbore:loop@incoherent"), Coherence::incoherent);
}

TEST(Engines, UnknownNamesAreAnErrorThatSuggestsANameOrListsAll) {
    for (const char* name : {"embre", "", "embree:loop", "exact:bounds", "moller-trumbore:tree",
                             "@coherent", "embree@fast", "embree-default-", "exact-single"}) {
        try {
            check_engine_name(name);
            FAIL() << name;
        } catch (const Error& e) {
            const std::string message = e.what();
            if (message.find("did you mean") != std::string::npos) continue;
            for (const std::string& known : engine_names())
                EXPECT_NE(message.find(known), std::string::npos) << known;
        }
    }
    const Scene scene = scene_of({globe(4)});
    const std::vector<std::string> names = {"embree", "nothing"};
    EXPECT_THROW(make_engines(scene, names), Error);
    EXPECT_THROW(make_engine(scene, "few-shapes"), Error);
}

TEST(Engines, DuplicateNamesCountOnce) {
    const Scene scene = scene_of({globe(4)});
    const std::vector<std::string> names = {"exact", "embree", "exact"};
    EXPECT_EQ(make_engines(scene, names).size(), 2u);
}

}  // namespace
}  // namespace sightline
