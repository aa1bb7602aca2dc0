// The exact tree is never wrong on any available scene.
#include "lab/compare/compare.h"

#include "core/error.h"
#include "core/hash.h"
#include "output/render_asset.h"
#include "render/camera_rays.h"
#include "support/rays.h"
#include "support/scenes.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr bool sanitized = SIGHTLINE_SANITIZED;  // thirty times slower: fewer rays

Tally judge_exact(const Scene& scene, std::span<const RecordedRay> rays) {
    const auto engines = make_engines(scene, std::vector<std::string>{"exact"});
    return compare(scene, Referee(scene), rays, engines, {.rounds = 1, .timed_rays = 1})
        .engines[0]
        .total();
}

/// Camera rays and, from their hits, rays in random directions and along the axes.
std::vector<RecordedRay> rays_through(const Scene& scene, int size) {
    RenderCommand command;
    command.settings.width = command.settings.height = size;
    const CameraRays camera(complete_settings(command, scene), scene.bounds);
    const auto embree = make_embree(scene);
    TestRandom random;
    std::vector<RecordedRay> rays;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const Ray ray = camera.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f,
                                       {0.5f, 0.5f});
            rays.push_back({ray, RayKind::camera});
            Hit hit;
            embree->closest({&ray, 1}, {&hit, 1}, Coherence::incoherent);
            if (!hit) continue;
            const Vec3 origin = ray.origin + ray.direction * hit.t;
            Vec3 axis(0, 0, 0);
            axis[x % 3] = y % 2 == 0 ? 1.0f : -1.0f;
            rays.push_back({{origin, 0, random.vector(1)}, RayKind::reflection});
            rays.push_back({{origin, 0, axis}, RayKind::refraction});
            rays.push_back({{origin, 0, random.vector(1), scene.bounds.size().length() * 0.1f},
                            RayKind::shadow});
        }
    return rays;
}

/// The rays of a small picture of the asset.
std::vector<RecordedRay> rendered_rays(const std::string& asset) {
    RenderCommand command;
    command.asset = asset;
    command.settings.width = sanitized ? 20 : 40;
    command.settings.height = sanitized ? 15 : 30;
    command.settings.samples = 1;
    command.output.keep_rays = true;
    return render_asset(command).picture.rays;
}

TEST(CompareSweep, TheExactTreeIsNeverWrongOnOurScenes) {
    for (const auto& entry : fs::directory_iterator(SIGHTLINE_SOURCE_DIR "/scenes")) {
        if (entry.path().extension() != ".gltf") continue;
        const Scene scene = load_gltf(entry.path().string());
        const Tally tally = judge_exact(scene, rendered_rays(entry.path().string()));
        EXPECT_GT(tally.judged(), sanitized ? 250u : 1000u) << entry.path();
        EXPECT_EQ(tally.wrong(), 0u) << entry.path();
        EXPECT_EQ(tally[Verdict::undecidable], 0u) << entry.path();
    }
}

TEST(CompareSweep, RecordedRaysNameTheSurfaceThatTheyLeave) {
    const std::string asset = SIGHTLINE_SOURCE_DIR "/scenes/table.gltf";
    const Scene scene = load_gltf(asset);
    size_t checked = 0;
    for (const RecordedRay& recorded : rendered_rays(asset)) {
        if (recorded.kind == RayKind::camera) {
            EXPECT_EQ(recorded.source, SurfaceId());
            continue;
        }
        ASSERT_LT(recorded.source.instance, scene.instances.size());
        if (!scene.is_mesh(recorded.source.geometry)) continue;
        const InstancedTriangle t = instanced_triangle(scene, recorded.source);
        if (t.to_world != nullptr) continue;
        const Vec3 normal = normalize(cross(t.b - t.a, t.c - t.a));
        const float height = dot(normal, recorded.ray.origin - t.a);
        EXPECT_LT(std::abs(height),
                  0.02f * scene.bounds.size().length());  // or on the smooth surface
        ++checked;
    }
    EXPECT_GT(checked, sanitized ? 250u : 1000u);
}

TEST(CompareSweep, TheExactTreeIsNeverWrongOnTheCorpus) {
    const fs::path corpus = SIGHTLINE_SOURCE_DIR "/../shared/corpus/valid";
    if (!fs::exists(corpus)) GTEST_SKIP() << "the corpus is not available";
    uint64_t judged = 0;
    for (const auto& entry : fs::recursive_directory_iterator(corpus)) {
        const std::string ending = entry.path().extension().string();
        if (ending != ".gltf" && ending != ".glb") continue;
        LoadOptions load;
        load.decode_images = false;
        load.allow_outside = true;
        Scene scene;
        try {
            scene = load_gltf(entry.path().string(), load);
        } catch (const Error&) {
            continue;  // other tests check which files must load
        }
        const auto rays = rays_through(scene, sanitized ? 6 : 12);
        const Tally tally = judge_exact(scene, rays);
        judged += tally.judged();
        EXPECT_EQ(tally.wrong(), 0u) << entry.path();
    }
    EXPECT_GT(judged, sanitized ? 2500u : 10000u);
    RecordProperty("judged", static_cast<int>(judged));
}

}  // namespace
}  // namespace sightline
