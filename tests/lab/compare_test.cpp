// Comparison of engines: verdicts, detection of faulty methods, invalid rays and degenerate scenes.
#include "lab/compare/compare.h"

#include "intersect/library_caller.h"
#include "intersect/ray_file.h"
#include "lab/compare/judging.h"
#include "support/mutants.h"
#include "support/rays.h"
#include "support/scenes.h"

#include <gtest/gtest.h>

#include <functional>

namespace sightline {
namespace {

/// An intersector that calls a function for each ray.
class Scripted : public Intersector {
  public:
    explicit Scripted(std::function<Hit(const Ray&)> answer) : answer_(std::move(answer)) {}

    void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence,
                 Visible) const override {
        for (size_t i = 0; i < rays.size(); ++i) hits[i] = answer_(rays[i]);
    }
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded, Coherence,
                  Visible) const override {
        for (size_t i = 0; i < rays.size(); ++i) occluded[i] = bool(answer_(rays[i]));
    }
    void all(std::span<const Ray> rays, std::vector<RayHit>& hits, Visible) const override {
        for (uint32_t i = 0; i < rays.size(); ++i)
            if (const Hit hit = answer_(rays[i])) hits.push_back({i, hit});
    }
    std::string description() const override { return "scripted"; }
    size_t memory() const override { return 0; }

  private:
    std::function<Hit(const Ray&)> answer_;
};

std::vector<Engine> scripted(const std::function<Hit(const Ray&)>& answer, size_t copies = 1) {
    std::vector<Engine> engines;
    for (size_t i = 0; i < copies; ++i)
        engines.push_back({"scripted", std::make_unique<Scripted>(answer)});
    return engines;
}

std::vector<RecordedRay> rays_from_inside(const Mesh& mesh, Aim aim, int count,
                                          RayKind kind = RayKind::camera) {
    TestRandom random;
    std::vector<RecordedRay> rays;
    for (int i = 0; i < count; ++i) rays.push_back({aimed_ray(mesh, aim, random), kind});
    return rays;
}

Comparison compare_all(const Scene& scene, const std::vector<RecordedRay>& rays,
                       const std::vector<Engine>& engines, CompareOptions options = {}) {
    options.rounds = 1;
    return compare(scene, Referee(scene), rays, engines, options);
}

Tally tally_of(Mutant mutant, Aim aim) {
    const Scene scene = scene_of({globe(12)});
    const Mesh& mesh = scene.meshes[0];
    const auto engines = scripted([&](const Ray& ray) { return trace_mutant(mesh, ray, mutant); });
    return compare_all(scene, rays_from_inside(mesh, aim, 4000), engines).engines[0].total();
}

/// An engine in front of a library, which must not get the rays that it does not take as they are.
class InFrontOfALibrary : public Scripted, public LibraryCaller {
  public:
    explicit InFrontOfALibrary(std::vector<Ray>& passed)
        : Scripted([](const Ray&) { return Hit{}; }), passed_(&passed) {}

    std::string_view trace_bare(std::span<const Ray> rays, bool any_hit, Coherence) const override {
        passed_->insert(passed_->end(), rays.begin(), rays.end());
        return any_hit ? "any" : "closest";
    }

  private:
    std::vector<Ray>* passed_;
};

TEST(Compare, TimesTheLibraryBehindAnEngineOnTheRaysThatItTakes) {
    const Scene scene = scene_of({globe(3)});
    const Ray fine{{0, 0, 3}, 0, {0, 0, -1}};
    const std::vector<RecordedRay> rays = {{fine, RayKind::camera},
                                           {{{0, 0, 3}, 0, {0, 0, 0}}, RayKind::camera},
                                           {{{0, 0, 3}, 0, {0, 0, 0x1p40f}}, RayKind::camera},
                                           {{{0, 0, 0x1p60f}, 0, {0, 0, -1}}, RayKind::camera},
                                           {fine, RayKind::shadow}};
    std::vector<Ray> passed;
    std::vector<Engine> engines = scripted([](const Ray&) { return Hit{}; });
    engines.push_back({"wrapper", std::make_unique<InFrontOfALibrary>(passed)});
    const Comparison result = compare_all(scene, rays, engines);
    const auto& [camera, shadow, reflection, refraction] = result.engines[1].kinds;
    ASSERT_TRUE(camera.wrapper && shadow.wrapper);
    EXPECT_EQ(camera.wrapper->library_call, "closest");
    EXPECT_EQ(shadow.wrapper->library_call, "any");
    EXPECT_GT(camera.wrapper->bare_ns, 0);
    EXPECT_GT(camera.wrapper->factor, 0);
    EXPECT_FALSE(reflection.wrapper || refraction.wrapper);
    EXPECT_FALSE(result.engines[0].kinds[0].wrapper);
    EXPECT_FALSE(passed.empty());
    for (const Ray& ray : passed) EXPECT_EQ(ray.direction, fine.direction);
    for (const Ray& ray : passed) EXPECT_EQ(ray.origin, fine.origin);
}

TEST(Compare, NotesThatEnginesShareTheirCodeForShapes) {
    const std::vector<std::string> names = {"exact", "embree", "few-shapes"};
    const Scene shapes = scene_of({}, {Shape()}), triangles = scene_of({globe(3)});
    const auto notes = compare_all(shapes, {}, make_engines(shapes, names)).notes;
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_TRUE(notes[0].starts_with("exact, embree solve")) << notes[0];
    const std::vector<std::string> apart = {"exact", "few-shapes"};
    EXPECT_TRUE(compare_all(shapes, {}, make_engines(shapes, apart)).notes.empty());
    const std::vector<std::string> both = {"exact", "embree"};
    EXPECT_TRUE(compare_all(triangles, {}, make_engines(triangles, both)).notes.empty());
}

TEST(Compare, FindsNothingWrongWithACorrectEngine) {
    const Tally tally = tally_of(Mutant::healthy, Aim::anywhere);
    EXPECT_EQ(tally.wrong(), 0u);
    EXPECT_EQ(tally.rays(), 4000u);
    EXPECT_LT(tally.t_ulps.max(), 100);
}

TEST(Compare, DetectsAFlippedSign) {
    EXPECT_GT(tally_of(Mutant::flipped_sign, Aim::anywhere).wrong(), 1000u);
}

TEST(Compare, DetectsAnEpsilonOnTheDeterminant) {
    const Tally tally = tally_of(Mutant::epsilon, Aim::anywhere);
    EXPECT_GT(tally[Verdict::missed], 10u);
    EXPECT_EQ(tally[Verdict::false_hit], 0u);
}

TEST(Compare, DetectsContraction) {
    EXPECT_EQ(tally_of(Mutant::healthy, Aim::edge)[Verdict::missed], 0u);
    EXPECT_GT(tally_of(Mutant::contraction, Aim::edge)[Verdict::missed], 0u);
}

TEST(Compare, DetectsAnErrorInT) {
    EXPECT_EQ(tally_of(Mutant::healthy, Aim::anywhere).wrong(), 0u);
    EXPECT_GT(tally_of(Mutant::shifted_t, Aim::anywhere)[Verdict::wrong_t], 3000u);
}

/// The exact engine's answers for rays at a globe, changed by `mutate`.
Tally tally_of_changed_hits(const std::function<Hit(const Ray&, Hit)>& mutate,
                            const CompareOptions& options = {}) {
    const Scene scene = scene_of({globe(12)});
    const auto exact = make_engines(scene, std::vector<std::string>{"exact"});
    const auto engines = scripted(
        [&](const Ray& ray) { return mutate(ray, closest(*exact[0].intersector, {ray})[0]); });
    return compare_all(scene, rays_from_inside(scene.meshes[0], Aim::anywhere, 4000), engines,
                       options)
        .engines[0]
        .total();
}

TEST(Compare, ConvictsADistanceThatIsTooLong) {
    EXPECT_EQ(tally_of_changed_hits([](const Ray&, Hit hit) { return hit; }).wrong(), 0u);
    const auto longer = [](const Ray&, Hit hit) {
        hit.t *= 1.001f;
        return hit;
    };
    const Tally tally = tally_of_changed_hits(longer);
    EXPECT_EQ(tally[Verdict::wrong_t], 4000u);
    EXPECT_EQ(tally.wrong(), 4000u);
    const auto not_a_number = [](const Ray&, Hit hit) {
        hit.t = NAN;
        return hit;
    };
    EXPECT_EQ(tally_of_changed_hits(not_a_number)[Verdict::wrong_t], 4000u);
}

TEST(Compare, ConvictsTheDistanceToOneTriangle) {
    size_t hits = 0;
    const auto longer = [&](const Ray&, Hit hit) {
        hits += hit.primitive == 100;
        if (hit.primitive == 100) hit.t *= 1.01f;
        return hit;
    };
    // Each ray is traced once more for the time.
    const Tally tally = tally_of_changed_hits(longer, {.timed_rays = 1, .threads = 1});
    EXPECT_GT(tally[Verdict::wrong_t], 3u);
    EXPECT_GE(hits, tally[Verdict::wrong_t]);
    EXPECT_EQ(tally.wrong(), tally[Verdict::wrong_t]);
}

TEST(Compare, ConvictsSwappedAndScaledBarycentrics) {
    const auto swapped = [](const Ray&, Hit hit) {
        std::swap(hit.u, hit.v);
        return hit;
    };
    const Tally tally = tally_of_changed_hits(swapped);
    EXPECT_GT(tally[Verdict::wrong_uv], 3990u);  // u and v are nearly equal on a few rays
    EXPECT_EQ(tally.wrong(), tally[Verdict::wrong_uv]);
    const auto too_large = [](const Ray&, Hit hit) {  // u + v + w = 1.001
        hit.u *= 1.001f;
        hit.v *= 1.001f;
        return hit;
    };
    EXPECT_GT(tally_of_changed_hits(too_large)[Verdict::wrong_uv], 3990u);
}

TEST(Compare, ConvictsTheFarthestHit) {
    const Scene scene = scene_of({globe(12)});
    TestRandom random;
    std::vector<RecordedRay> rays;
    for (int i = 0; i < 2000; ++i)
        rays.push_back(
            {aimed_ray(scene.meshes[0], Aim::anywhere, random, {0, 0, 3}, 0.1f), RayKind::camera});
    const Referee referee(scene);
    const auto farthest = scripted([&](const Ray& ray) {
        const auto all = referee.all(ray);
        if (all.empty()) return Hit{};
        const SurfaceId id = all.back().surface;
        return compute_exact_hit(scene, ray, {{id}, all.back().t}, id);
    });
    const Tally tally = compare_all(scene, rays, farthest).engines[0].total();
    EXPECT_GT(tally[Verdict::wrong_primitive], 20u);
    EXPECT_EQ(tally.wrong(), tally[Verdict::wrong_primitive]);
}

TEST(Compare, ConvictsAnEngineThatLosesOneTriangleInAThousand) {
    const Scene scene = scene_of({globe(32)});
    const Mesh& mesh = scene.meshes[0];
    ASSERT_GT(mesh.triangles.size(), 2000u);
    const auto exact = make_engines(scene, std::vector<std::string>{"exact"});
    const auto engines = scripted([&](const Ray& ray) {
        const Hit hit = closest(*exact[0].intersector, {ray})[0];
        return hit.primitive % 1000 == 500 ? Hit{} : hit;
    });
    const auto rays = rays_from_inside(mesh, Aim::anywhere, 20000);
    const Tally tally = compare_all(scene, rays, engines).engines[0].total();
    EXPECT_GT(tally[Verdict::missed], 3u);
    EXPECT_EQ(tally.wrong(), tally[Verdict::missed]);
}

TEST(Compare, ConvictsTheOtherRootOfAShape) {
    Shape sphere;
    sphere.radius = 1;
    const Scene scene = scene_of({}, {sphere});
    TestRandom random;
    std::vector<RecordedRay> rays;
    for (int i = 0; i < 40; ++i) {
        const Vec3 origin = Vec3(0, 0, 3) + random.vector(0.5f);
        rays.push_back({{origin, 0, random.vector(0.5f) - origin}, RayKind::camera});
    }
    const Referee referee(scene);
    const auto root = [&](size_t which) {
        return [&, which](const Ray& ray) {
            return Hit{static_cast<float>(referee.all(ray).at(which).t), 0, 0, 0, 0, 0};
        };
    };
    EXPECT_EQ(compare_all(scene, rays, scripted(root(0))).engines[0].total().wrong(), 0u);
    const Tally tally = compare_all(scene, rays, scripted(root(1))).engines[0].total();
    EXPECT_EQ(tally[Verdict::wrong_t], 40u);
}

TEST(Compare, ConvictsHitsOfTheSurfaceThatTheRayLeaves) {
    // Rays leave the plane y = 0 upwards; an engine in floats may find the plane at a tiny t.
    Mesh plane;
    plane.positions = {{-9, 0, -9}, {9, 0, -9}, {0, 0, 9}};
    plane.triangles = {{0, 1, 2}};
    const Scene scene = scene_of({plane});
    TestRandom random;
    std::vector<RecordedRay> rays;
    for (const RayKind kind : {RayKind::reflection, RayKind::shadow})
        for (int i = 0; i < 500; ++i) {
            const Vec3 origin(random.between(-1, 1), i % 2 ? 0 : 0x1p-23f, random.between(-1, 1));
            const Vec3 direction(random.between(-1, 1), random.between(0.1f, 1), 0);
            rays.push_back({{origin, 0, direction}, kind});
        }
    const auto acne = scripted([](const Ray&) { return Hit{0x1p-23f, 0.25f, 0.25f, 0, 0, 0}; });
    const Tally unknown = compare_all(scene, rays, acne).engines[0].total();
    EXPECT_EQ(unknown[Verdict::false_hit], 1000u);
    for (RecordedRay& ray : rays) ray.source = {0, 0, 0};
    const Tally known = compare_all(scene, rays, acne).engines[0].total();
    EXPECT_EQ(known[Verdict::false_hit], 1000u);
}

TEST(Compare, ExcusesHitsOfOtherSurfacesThatAnUlpWouldHit) {
    // Above a triangle's edge by less than an ulp of the coordinates.
    Mesh wall;
    wall.positions = {{-9, 0, 1}, {9, 0, 1}, {0, -9, 1}};
    wall.triangles = {{0, 1, 2}};
    const Scene scene = scene_of({wall});
    const std::vector<RecordedRay> rays = {{{{0.5f, 0x1p-26f, 0}, 0, {0, 0, 1}}, RayKind::camera},
                                           {{{0.5f, 0x1p-20f, 0}, 0, {0, 0, 1}}, RayKind::camera}};
    const Hit on_the_edge =
        compute_exact_hit(scene, {{0.5f, 0, 0}, 0, {0, 0, 1}}, {{{0, 0, 0}}, 1}, {0, 0, 0});
    const Tally tally = compare_all(scene, rays, scripted([&](const Ray&) { return on_the_edge; }))
                            .engines[0]
                            .total();
    EXPECT_EQ(tally[Verdict::undecidable], 1u);
    EXPECT_EQ(tally[Verdict::false_hit], 1u);
}

TEST(Compare, CountsWrongAnswersAsWrongEvenIfAllEnginesAgree) {
    const Scene scene = scene_of({globe(8)});
    const auto rays = rays_from_inside(scene.meshes[0], Aim::anywhere, 3000);
    const auto blind = scripted([](const Ray&) { return Hit{}; }, 2);
    const Tally all = compare_all(scene, rays, blind).engines[0].total();
    EXPECT_EQ(all[Verdict::missed], 3000u);
    const Tally some = compare_all(scene, rays, blind, {.max_judged = 300}).engines[1].total();
    EXPECT_EQ(some[Verdict::same], 0u);
    EXPECT_GT(some[Verdict::missed], 200u);
    EXPECT_LT(some[Verdict::missed], 400u);
    EXPECT_EQ(some.unchecked + some[Verdict::missed], 3000u);
}

TEST(Compare, JudgesEveryDisagreementEvenWithoutASample) {
    const Scene scene = scene_of({globe(8)});
    const auto rays = rays_from_inside(scene.meshes[0], Aim::anywhere, 3000);
    auto engines = make_engines(scene, std::vector<std::string>{"exact"});
    int calls = 0;
    for (Engine& engine : scripted([&](const Ray& ray) {
             return ++calls % 100 == 0 ? Hit{}
                                       : trace_mutant(scene.meshes[0], ray, Mutant::healthy);
         }))
        engines.push_back(std::move(engine));
    CompareOptions options{.max_judged = 0, .timed_rays = 1, .threads = 1};
    const Comparison comparison = compare_all(scene, rays, engines, options);
    EXPECT_EQ(comparison.engines[0].total().wrong(), 0u);
    EXPECT_GE(comparison.engines[1].total()[Verdict::missed], 29u);
    EXPECT_GT(comparison.engines[0].total().unchecked, 2900u);
}

TEST(Compare, DoesNotDependOnTheNumberOfThreads) {
    const Scene scene = scene_of({globe(12)});
    const auto rays = rays_from_inside(scene.meshes[0], Aim::edge, 8000);
    const auto engines =
        make_engines(scene, std::vector<std::string>{"embree-default", "moller-trumbore"});
    const Comparison one = compare_all(scene, rays, engines, {.threads = 1});
    const Comparison four = compare_all(scene, rays, engines, {.threads = 4});
    ASSERT_EQ(one.findings.size(), four.findings.size());
    EXPECT_GT(one.findings.size(), 0u);
    for (size_t i = 0; i < one.findings.size(); ++i) {
        EXPECT_EQ(one.findings[i].ray, four.findings[i].ray);
        EXPECT_EQ(one.findings[i].verdict, four.findings[i].verdict);
    }
    EXPECT_EQ(one.engines[1].kinds[0].worst_t_ray, four.engines[1].kinds[0].worst_t_ray);
}

TEST(Compare, TracesShadowRaysByAnyHitQueries) {
    const Scene scene = scene_of({globe(8)});
    const auto rays = rays_from_inside(scene.meshes[0], Aim::anywhere, 100, RayKind::shadow);
    const auto engines = make_engines(scene, std::vector<std::string>{"embree", "exact"});
    const Comparison comparison = compare_all(scene, rays, engines);
    EXPECT_EQ(comparison.rays[1], 100u);
    EXPECT_EQ(comparison.engines[0].kinds[1].tally[Verdict::same], 100u);
    const auto blind = scripted([](const Ray&) { return Hit{}; });
    EXPECT_EQ(compare_all(scene, rays, blind).engines[0].kinds[1].tally[Verdict::missed], 100u);
}

std::vector<RecordedRay> invalid_rays() {
    const Vec3 o(0.1f, 0.2f, 3), d(0, 0, -1);
    std::vector<RecordedRay> rays;
    for (const Ray& ray :
         {Ray{o, 0, {0, 0, 0}, infinity}, Ray{{NAN, 0, 3}, 0, d, infinity},
          Ray{o, 0, {0, 0, -infinity}, infinity}, Ray{o, 0, {0, NAN, -1}, infinity},
          Ray{o, 5, d, 1}, Ray{o, NAN, d, infinity}, Ray{o, 0, d, NAN}, Ray{o, -10, d, infinity},
          Ray{{0.1f, infinity, 3}, 0, d, infinity}, Ray{o, infinity, d, infinity}})
        for (const RayKind kind : {RayKind::camera, RayKind::shadow}) rays.push_back({ray, kind});
    return rays;
}

TEST(Compare, TreatsInvalidRaysAsMisses) {
    const Scene scene = scene_of({globe(8)});
    const auto rays = invalid_rays();
    std::vector<std::string> names = engine_names();
    std::erase(names, "few-shapes");
    const auto engines = make_engines(scene, names);
    const Comparison comparison = compare_all(scene, rays, engines);
    EXPECT_EQ(comparison.invalid_rays, rays.size());
    for (const EngineScore& engine : comparison.engines)
        EXPECT_EQ(engine.total()[Verdict::same], rays.size()) << engine.name;
    const auto eager = scripted([](const Ray&) { return Hit{1, 0, 0, 0, 0, 0}; });
    EXPECT_EQ(compare_all(scene, rays, eager).engines[0].total()[Verdict::false_hit], rays.size());
}

TEST(Compare, JudgesScenesWithDegenerateNanAndHugeVertices) {
    Mesh mesh = globe(6);
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (const Vec3& p : {Vec3(NAN, 0, 0), Vec3(1e30f, 1, -3), Vec3(-1e30f, 1, -3),
                          Vec3(0, 1e30f, -3), Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(infinity, 0, 0)})
        mesh.positions.push_back(p);
    mesh.triangles.push_back({first, 0, 1});
    mesh.triangles.push_back({first + 1, first + 2, first + 3});  // fills the view, far away
    mesh.triangles.push_back({first + 4, first + 5, 1});
    mesh.triangles.push_back({first + 6, 2, 3});
    mesh.positions.reserve(mesh.positions.size() + 1);
    const Scene scene = scene_of({mesh});
    std::vector<RecordedRay> rays;
    TestRandom random;
    for (int i = 0; i < 2000; ++i)
        rays.push_back({{random.vector(2), 0, random.vector(1)}, RayKind::camera});
    rays.push_back({{{0, 5, 0}, 0, {0, 0.1f, -1}}, RayKind::camera});
    std::vector<std::string> names = engine_names();
    std::erase(names, "few-shapes");
    const auto engines = make_engines(scene, names);
    const Comparison comparison = compare_all(scene, rays, engines);
    for (const EngineScore& engine : comparison.engines) {
        EXPECT_EQ(engine.total().rays(), rays.size());
        if (engine.name == "exact") {
            EXPECT_EQ(engine.total().wrong(), 0u);
        } else if (engine.name == "embree") {
            EXPECT_GT(engine.total()[Verdict::missed], 0u);
        }
    }
}

TEST(Compare, AcceptsNoRaysAndScenesWithoutHits) {
    const Scene scene = scene_of({});
    const auto engines = make_engines(scene, std::vector<std::string>{"embree", "exact"});
    const Comparison none_fired = compare_all(scene, {}, engines);
    EXPECT_EQ(none_fired.engines[0].total().rays(), 0u);
    const std::vector<RecordedRay> rays = {{{{0, 0, 0}, 0, {0, 0, 1}}, RayKind::reflection}};
    const Comparison comparison = compare_all(scene, rays, engines);
    EXPECT_EQ(comparison.engines[1].total()[Verdict::same], 1u);
}

TEST(Compare, CountsSelfHits) {
    const Scene scene = scene_of({globe(8)});
    const Vec3 vertex = scene.meshes[0].positions[20];
    const std::vector<RecordedRay> rays = {
        {{vertex * (1 - 0x1p-22f), 0, vertex}, RayKind::reflection},
        {{vertex * 0.5f, 0, vertex}, RayKind::reflection}};
    const auto engines = make_engines(scene, std::vector<std::string>{"exact"});
    EXPECT_EQ(compare_all(scene, rays, engines).engines[0].total().self_hits, 1u);
}

TEST(Compare, InspectsASingleRay) {
    const Scene scene = scene_of({globe(8)});
    auto engines = make_engines(scene, std::vector<std::string>{"exact"});
    for (Engine& engine : scripted([](const Ray&) { return Hit{}; }))
        engines.push_back(std::move(engine));
    const RayReport report =
        inspect(scene, Referee(scene), engines,
                {{{0.01f, 0.02f, 0.03f}, 0, {0.3f, 1, 0.2f}}, RayKind::camera});
    ASSERT_EQ(report.answers.size(), 2u);
    EXPECT_EQ(report.answers[0].verdict, Verdict::same);
    EXPECT_LE(report.answers[0].t_ulps, 0.5);
    EXPECT_EQ(report.answers[1].verdict, Verdict::missed);
    EXPECT_EQ(report.answers[1].occlusion_verdict, Verdict::missed);
}

}  // namespace
}  // namespace sightline
