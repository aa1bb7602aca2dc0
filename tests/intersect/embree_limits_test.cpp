// Characterisation tests: what Embree itself does at its limits, one ray at a time, and how the
// renderer handles it. They describe the packaged versions and may fail after an upgrade of Embree;
// then docs/embree.md and embree.cpp need the new facts.
#include "exact/referee.h"
#include "intersect/embree/embree.h"
#include "intersect/embree/embree_api.h"
#include "intersect/engines.h"
#include "scene/gltf/load.h"
#include "support/gltf.h"
#include "support/rays.h"
#include "support/scenes.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

namespace sightline {
namespace {

/// Embree alone: one mesh, optionally below levels of instances with the identity matrix.
class RawEmbree {
  public:
    RawEmbree(const Mesh& mesh, bool robust, const std::string& isa = "", int levels = 0)
        : device_(rtcNewDevice(isa.empty() ? "" : ("isa=" + isa).c_str())),
          scene_(new_scene(robust)) {
        GeometryHandle geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
        void* vertices =
            rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    sizeof(Vec3), mesh.positions.size());
        std::copy(mesh.positions.begin(), mesh.positions.end(), static_cast<Vec3*>(vertices));
        void* indices =
            rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    sizeof mesh.triangles[0], mesh.triangles.size());
        std::memcpy(indices, mesh.triangles.data(),
                    mesh.triangles.size() * sizeof mesh.triangles[0]);
        attach(scene_.get(), std::move(geometry));
        for (int level = 0; level < levels; ++level) {
            SceneHandle above = new_scene(robust);
            GeometryHandle instance(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE));
            rtcSetGeometryInstancedScene(instance.get(), scene_.get());
            attach(above.get(), std::move(instance));
            scene_ = std::move(above);  // the instance keeps the other
        }
    }

    bool hits(const Ray& ray) const {
        RTCRayHit query{};
        query.ray.org_x = ray.origin.x, query.ray.org_y = ray.origin.y;
        query.ray.org_z = ray.origin.z, query.ray.tnear = ray.tnear;
        query.ray.dir_x = ray.direction.x, query.ray.dir_y = ray.direction.y;
        query.ray.dir_z = ray.direction.z, query.ray.tfar = ray.tfar;
        query.ray.mask = ~0u;
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        Query flags(false);
        trace(scene_.get(), flags, query);
        return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }

    size_t misses(const std::vector<Ray>& rays) const {
        return static_cast<size_t>(
            std::count_if(rays.begin(), rays.end(), [&](const Ray& ray) { return !hits(ray); }));
    }

    RTCError error() const { return rtcGetDeviceError(device_.get()); }

  private:
    SceneHandle new_scene(bool robust) const {
        SceneHandle scene(rtcNewScene(device_.get()));
        rtcSetSceneFlags(scene.get(), robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
        return scene;
    }
    static void attach(RTCScene scene, GeometryHandle geometry) {
        rtcCommitGeometry(geometry.get());
        rtcAttachGeometry(scene, geometry.get());
        rtcCommitScene(scene);
    }

    DeviceHandle device_;
    SceneHandle scene_;
};

size_t misses(const Intersector& engine, const std::vector<Ray>& rays) {
    const auto hits = closest(engine, rays);
    return static_cast<size_t>(
        std::count_if(hits.begin(), hits.end(), [](const Hit& hit) { return !hit; }));
}

// Only another engine can handle rays aimed at vertices. The renderer's own rays start at hashed
// positions within their pixels, so they are not aimed at vertices.
TEST(EmbreeLimits, RobustLeaksAtVerticesAndTheExactEngineDoesNot) {
    const Scene scene = scene_of({sphere_mesh(128, 128)});
    const RawEmbree raw(scene.meshes[0], true);
    const auto aimed = rays_from_inside(scene.meshes[0], {0, 0, 0}, Aim::vertex, 50000, 21);
    const auto anywhere = rays_from_inside(scene.meshes[0], {0, 0, 0}, Aim::anywhere, 100000, 22);
    const size_t leaks = raw.misses(aimed);
    RecordProperty("robust_misses_of_50000_at_vertices", static_cast<int>(leaks));
    EXPECT_GT(leaks, 0u);
    EXPECT_EQ(misses(*make_engine(scene, "exact"), aimed), 0u);
    EXPECT_EQ(misses(*make_embree(scene), anywhere), 0u);
}

TEST(EmbreeLimits, RobustIncludesTnearAndTheRendererExcludesIt) {
    const Scene scene = scene_of({triangle_mesh(0)});
    const Ray on_surface{{1, 1, 0}, 0, {0, 0, -1}, infinity};
    EXPECT_TRUE(RawEmbree(scene.meshes[0], true).hits(on_surface));
    EXPECT_FALSE(RawEmbree(scene.meshes[0], false).hits(on_surface));
    for (const bool robust : {true, false}) {
        EXPECT_FALSE(occluded(*make_embree(scene, {.robust = robust}), {on_surface})[0]);
    }
}

TEST(EmbreeLimits, HugeVerticesAreDroppedSilentlyAndTheRendererReportsThem) {
    Mesh mesh = triangle_mesh(0);
    mesh.positions[2].y = 1e30f;
    const Scene scene = scene_of({mesh});
    const Ray ray{{1, 1, 3}, 0, {0, 0, -1}, infinity};
    const RawEmbree raw(mesh, true);
    EXPECT_FALSE(raw.hits(ray));
    EXPECT_EQ(raw.error(), RTC_ERROR_NONE);
    EXPECT_FALSE(Referee(scene).closest(ray).nearest.empty());  // it is there
    const auto engine = make_embree(scene);
    ASSERT_EQ(engine->warnings().size(), 1u);
    EXPECT_EQ(engine->warnings()[0].substr(0, 11), "1 triangles");
    EXPECT_TRUE(closest(*make_engine(scene, "exact"), {ray})[0]);
}

bool lost_or_aborted(int status) { return WIFSIGNALED(status) || WEXITSTATUS(status) == 1; }

// Debian builds Embree for one level of instances; glTF nests nodes to any depth.
TEST(EmbreeLimits, NestedInstancesEndTheProcessAndTheRendererUsesOneLevel) {
    const Ray ray{{0.25f, 0.25f, 3}, 0, {0, 0, -1}, infinity};
    EXPECT_TRUE(RawEmbree(triangle_mesh(0), true, "", 1).hits(ray));
    const RawEmbree deep(triangle_mesh(0), true, "", RTC_MAX_INSTANCE_LEVEL_COUNT + 1);
    EXPECT_EXIT(_exit(deep.hits(ray) ? 0 : 1), lost_or_aborted, "");

    GltfBuilder gltf;
    const size_t positions = gltf.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
    gltf.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}}}}}};
    gltf.json["nodes"] = {{{"mesh", 0}},
                          {{"children", {0}}, {"translation", {0, 0, 1}}},
                          {{"children", {1}}, {"translation", {4, 0, 0}}},
                          {{"mesh", 0}, {"children", {2}}}};
    gltf.json["scenes"] = {{{"nodes", {3}}}};
    const Scene scene = load_gltf(gltf.save());
    const auto engine = make_embree(scene);
    const auto hits = closest(*engine, {ray, {{4.25f, 0.25f, 3}, 0, {0, 0, -1}, infinity}});
    EXPECT_FLOAT_EQ(hits[0].t, 3);
    EXPECT_FLOAT_EQ(hits[1].t, 2);
}

// Rays leak at different edges on different instruction sets. With a pinned set the answers are the
// same bits; otherwise the description names the set, and so do pictures and statistics.
TEST(EmbreeLimits, AnswersDependOnTheInstructionSetWhichIsReportedAndCanBePinned) {
    const Scene scene = scene_of({sphere_mesh(64, 64)});
    if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "this processor lacks AVX2";
    const RawEmbree old(scene.meshes[0], false, "sse4.2"), wide(scene.meshes[0], false, "avx2");
    const auto rays = rays_from_inside(scene.meshes[0], {0, 0, 0}, Aim::vertex, 20000, 23);
    const size_t on_sse = old.misses(rays), on_avx2 = wide.misses(rays);
    RecordProperty("default_misses_of_20000_with_sse4_2", static_cast<int>(on_sse));
    RecordProperty("default_misses_of_20000_with_avx2", static_cast<int>(on_avx2));
    EXPECT_NE(on_sse, on_avx2);

    const auto first = closest(*make_embree(scene, {.isa = "sse4.2"}), rays);
    const auto again = closest(*make_embree(scene, {.isa = "sse4.2"}), rays);
    EXPECT_EQ(std::memcmp(first.data(), again.data(), first.size() * sizeof(Hit)), 0);

    const std::string best = make_embree(scene)->description();
    const std::string isa = best.substr(best.rfind(' ') + 1);
    ASSERT_TRUE(isa.starts_with("avx")) << best;
    EXPECT_EQ(make_embree(scene, {.isa = isa})->description(), best);
    const auto unpinned = closest(*make_embree(scene), rays);
    const auto pinned = closest(*make_embree(scene, {.isa = isa}), rays);
    EXPECT_EQ(std::memcmp(unpinned.data(), pinned.data(), pinned.size() * sizeof(Hit)), 0);
}

}  // namespace
}  // namespace sightline
