// Answers of other programs: files of them, triangles for them, and how they are judged.
#include "lab/compare/answers.h"

#include "core/error.h"
#include "core/files.h"
#include "lab/compare/compare.h"
#include "lab/compare/triangle_file.h"
#include "support/rays.h"
#include "support/scenes.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

namespace sightline {
namespace {

/// A globe, a sheared copy of it, and rays at both.
struct Exchange {
    Scene scene = scene_of({globe(8)});
    RayFile rays;
    std::vector<Hit> hits;
    std::vector<uint8_t> blocked;

    Exchange() {
        Mat4 matrix;
        matrix[1][0] = 0.5f;
        matrix[3][0] = 3;
        scene.instances[0].baked = false;
        scene.instances.push_back(make_instance(0, matrix));
        TestRandom random;
        std::vector<RecordedRay> recorded;
        for (int i = 0; i < 400; ++i)
            recorded.push_back({aimed_ray(scene.meshes[0], Aim::anywhere, random),
                                i % 2 ? RayKind::reflection : RayKind::shadow});
        write_rays(path("rays"), recorded, scene);
        rays = read_rays(path("rays"));
        const auto exact = make_engine(scene, "exact");
        hits.resize(rays.rays.size());
        blocked.resize(rays.rays.size());
        for (size_t i = 0; i < rays.rays.size(); ++i) {
            const Ray& ray = rays.rays[i].ray;
            exact->closest({&ray, 1}, {&hits[i], 1}, Coherence::incoherent);
            exact->occluded({&ray, 1}, {&blocked[i], 1}, Coherence::incoherent);
        }
    }

    static std::string path(const char* name) { return (test_folder() / name).string(); }

    Tally judge() const {
        write_answers(path("answers"), hits, blocked, scene, rays);
        std::vector<Engine> engines;
        engines.push_back(read_answers("mine", path("answers"), scene, rays));
        return compare(scene, Referee(scene), rays.rays, engines, {.rounds = 1}).engines[0].total();
    }

    /// What read_answers says of the answers, changed by `change`.
    std::string message(const std::function<void(std::string& bytes)>& change) const {
        write_answers(path("answers"), hits, blocked, scene, rays);
        std::ifstream file(path("answers"), std::ios::binary);
        std::string bytes(std::istreambuf_iterator<char>(file), {});
        change(bytes);
        std::ofstream(path("changed"), std::ios::binary) << bytes;
        try {
            read_answers("mine", path("changed"), scene, rays);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }
};

constexpr size_t header = 32, record = 28;

template <class T>
auto put(size_t at, T value) {
    return
        [at, value](std::string& bytes) { std::memcpy(bytes.data() + at, &value, sizeof value); };
}

TEST(Answers, AreJudgedAsThoseOfAnEngine) {
    Exchange exchange;
    EXPECT_EQ(exchange.judge()[Verdict::same], 400u);
    exchange.hits[1].t *= 1.001f;
    exchange.hits[3] = {};
    exchange.blocked[4] ^= 1;
    const Tally tally = exchange.judge();
    EXPECT_EQ(tally[Verdict::wrong_t], 1u);
    EXPECT_EQ(tally.wrong(), 3u);
}

TEST(Answers, OfAnotherLengthSceneVersionOrRaysAreRefused) {
    const Exchange exchange;
    EXPECT_EQ(exchange.message([](std::string&) {}), "");
    EXPECT_NE(exchange.message([](std::string& bytes) { bytes.pop_back(); }).find("truncated"),
              std::string::npos);
    EXPECT_NE(exchange.message([](std::string& bytes) { bytes.resize(12); }).find("not a file"),
              std::string::npos);
    EXPECT_NE(exchange.message(put(6, '2')).find("not a file of answers"), std::string::npos);
    EXPECT_NE(exchange.message(put(8, uint64_t{399})).find("399 rays of another file"),
              std::string::npos);
    EXPECT_NE(exchange.message(put(16, uint64_t{1})).find("another scene"), std::string::npos);
    EXPECT_NE(exchange.message(put(24, uint64_t{1})).find("of another file"), std::string::npos);
}

TEST(Answers, ThatCannotBeAreRefusedWithTheirRay) {
    const Exchange exchange;
    ASSERT_TRUE(exchange.hits[1]);
    const size_t at = header + record;
    const auto message = [&](size_t field, auto value) {
        return exchange.message(put(at + field, value));
    };
    EXPECT_NE(message(0, uint32_t{2}).find("ray 1: there is no instance 2"), std::string::npos);
    EXPECT_NE(message(4, uint32_t{7}).find("ray 1: instance 0 has no geometry 7"),
              std::string::npos);
    EXPECT_NE(message(8, uint32_t{99999}).find("ray 1: there is no primitive 99999"),
              std::string::npos);
    EXPECT_NE(message(12, NAN).find("ray 1: t, u or v is nan"), std::string::npos);
    EXPECT_NE(message(12, -1.0f).find("ray 1: t -1 is not in the ray's segment"),
              std::string::npos);
    EXPECT_NE(message(24, uint32_t{2}).find("ray 1: occluded is 2"), std::string::npos);
}

TEST(Answers, MayGiveTheTimeOfARay) {
    const Exchange exchange;
    write_answers(Exchange::path("answers"), exchange.hits, exchange.blocked, exchange.scene,
                  exchange.rays);
    const double times[] = {NAN, 12, 34, NAN};
    std::ofstream(Exchange::path("answers"), std::ios::binary | std::ios::app)
        .write(reinterpret_cast<const char*>(times), sizeof times);
    std::vector<Engine> engines;
    engines.push_back(
        read_answers("mine", Exchange::path("answers"), exchange.scene, exchange.rays));
    const Comparison comparison = compare(exchange.scene, Referee(exchange.scene),
                                          exchange.rays.rays, engines, {.rounds = 3});
    EXPECT_EQ(comparison.engines[0].kinds[1].median_ns(), 12);
    EXPECT_EQ(comparison.engines[0].kinds[2].median_ns(), 34);
}

TEST(Flatten, StoresEachInstanceInWorldSpaceAndKeepsWhatRaysHit) {
    const Exchange exchange;
    const Scene flat = flatten(exchange.scene);
    ASSERT_EQ(flat.meshes.size(), 2u);
    ASSERT_EQ(flat.instances.size(), 2u);
    EXPECT_TRUE(flat.instances[1].baked);
    EXPECT_NEAR(flat.meshes[1].positions[5].x,
                exchange.scene.meshes[0].positions[5].x + 3 +
                    0.5f * exchange.scene.meshes[0].positions[5].y,
                1e-6f);
    const Referee before(exchange.scene), after(flat);
    for (const RecordedRay& ray : exchange.rays.rays) {
        const Truth a = before.closest(ray.ray), b = after.closest(ray.ray);
        ASSERT_EQ(a.nearest.size(), b.nearest.size());
        EXPECT_EQ(a.nearest[0].instance, b.nearest[0].instance);
        EXPECT_NEAR(a.t, b.t, 1e-5 * a.t);
    }
}

TEST(Flatten, KeepsShapesWithTheirMatrix) {
    Scene scene = scene_of({}, {Shape()});
    Mat4 matrix;
    matrix[3][0] = 3;
    scene.instances[0].baked = false;
    scene.instances.push_back(make_instance(0, matrix));
    const Scene flat = flatten(scene);
    const Ray ray{{3, 0, 5}, 0, {0, 0, -1}};
    EXPECT_EQ(Referee(scene).closest(ray).t, 4.5);
    EXPECT_EQ(Referee(flat).closest(ray).t, 4.5);
}

}  // namespace
}  // namespace sightline
