// Which surfaces are alone, so that nothing that coincides with hits on them is searched for.
#include "render/lone_surfaces.h"

#include "core/sampler.h"
#include "intersect/engines.h"
#include "intersect/timed_intersector.h"
#include "render/coincident_hits.h"
#include "support/pictures.h"

namespace sightline {
namespace {

// An engine that cannot tell what is nearby.
class Blind final : public TimedIntersector {
  public:
    using TimedIntersector::TimedIntersector;
    bool nearby(const Vec3&, float, size_t, std::vector<SurfaceId>&) const override {
        return false;
    }
};

constexpr int often = 40;  // asked so often, a surface is judged

bool is_lone_at_last(const LoneSurfaces& lone, const Hit& hit, float distance) {
    for (int i = 0; i < often; ++i) lone.is_lone(hit, distance);
    return lone.is_lone(hit, distance);
}

Hit middle_of(uint32_t primitive, uint32_t geometry = 0, uint32_t instance = 0) {
    return {1, 0.3f, 0.3f, primitive, geometry, instance};
}

Mesh flipped(Mesh mesh) {
    for (auto& [a, b, c] : mesh.triangles) std::swap(b, c);
    return mesh;
}

// A square in n × n quads around the origin.
Mesh square(int n, float size, float height) {
    const Vec3 across = normalize(Vec3(1, 0.1f, 0.3f)), up = normalize(Vec3(-0.1f, 1, 0.07f));
    const float step = size / static_cast<float>(n);
    Mesh mesh;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const Vec3 corner = across * (step * static_cast<float>(i) - size / 2) +
                                up * (step * static_cast<float>(j) - size / 2) + Vec3(0, 0, height);
            const auto first = static_cast<uint32_t>(mesh.positions.size());
            for (const Vec3& p : {Vec3(0), across * step, (across + up) * step, up * step})
                mesh.positions.push_back(corner + p);
            mesh.triangles.push_back({first, first + 1, first + 2});
            mesh.triangles.push_back({first, first + 2, first + 3});
        }
    return mesh;
}

// Copies of all kinds, squares that cross each other, a fold, a ball on a floor; some instanced.
Scene crowded_scene() {
    SceneBuilder builder;
    Material half = matte({1, 1, 1});
    half.base_color_factor.w = 0.5f;
    half.alpha_mode = AlphaMode::blend;
    const uint32_t m = builder.add_material(half);
    const auto add = [&](Mesh mesh) { builder.add_instance(builder.add_mesh(std::move(mesh), m)); };
    add(square(4, 2, 0));
    add(flipped(square(3, 1, 0)));
    add(square(4, 2, 0.5f));
    add(square(5, 1.5f, 0.5f + 1e-7f));
    add(square(2, 2, 1));
    add(quad_mesh({-1, 0.2f, 0.3f}, {2, 0, 0}, {0, 0.1f, 1}));
    Mesh fold = triangle_mesh(1.5f);
    fold.positions.push_back({0, 3.9f, 1.5f + 1e-6f});
    fold.triangles.push_back({1, 0, 3});
    add(std::move(fold));
    const uint32_t part = builder.add_mesh(square(3, 1, 2), m);
    Mat4 turned;
    turned.rotate(Vec3(0.1f, 0.2f, 0.7f));
    turned.translate(Vec3(0.3f, 0.1f, 0.4f));
    Mat4 lifted = turned;
    lifted.translate(Vec3(0.05f, 0.02f, 0));
    builder.add_instance(part, turned);
    builder.add_instance(part, lifted);
    add(ball({0, 0, -2}, 1));
    add(quad_mesh({-2, -2, -3}, {4, 0, 0}, {0, 4, 0}));
    return builder.finish();
}

TEST(LoneSurfaces, NothingCoincidesWithHitsOnThem) {
    const Scene scene = crowded_scene();
    const auto engine = make_engine(scene, "embree");
    const Surfaces surfaces(scene, false, 1);
    const Blind blind(*engine);
    const LoneSurfaces lone(scene, *engine), unknown(scene, blind);
    CoincidentHits known_hits(scene, *engine, lone, {}), all_hits(scene, *engine, unknown, {});
    int alone = 0, together = 0;
    for (uint32_t i = 0; i < (SIGHTLINE_SANITIZED ? 20000 : 200000); ++i) {
        const Vec2 from = sample_2d(i, 1) * 6 - Vec2(3), to = sample_2d(i, 2) * 4 - Vec2(2);
        const float height = sample_1d(i, 3) * 6 - 3;
        Ray ray{{from.x, from.y, 5}, 0, Vec3(to.x, to.y, height) - Vec3(from.x, from.y, 5)};
        for (int layer = 0; layer < 4; ++layer) {
            Hit hit;
            engine->closest({&ray, 1}, {&hit, 1}, Coherence::incoherent);
            if (!hit) break;
            Surface surface = surfaces.at(ray, hit, 0, Faces::all);
            all_hits.clear();
            const size_t index = all_hits.add(ray, hit, surface).value();
            all_hits.search(Visible::all);
            const bool coincides = all_hits.at(index).size() > 1;
            known_hits.clear();
            const bool skipped = !known_hits.add(ray, hit, surface);
            EXPECT_FALSE(skipped && coincides) << i << ", layer " << layer;
            alone += skipped, together += coincides;
            all_hits.widen(surface);
            ray = spawn_ray(surface, ray.direction, std::numeric_limits<float>::infinity());
        }
    }
    EXPECT_GT(alone, together / 4);
    EXPECT_GT(together, 1000);
}

TEST(LoneSurfaces, AreTrianglesOfAMeshButNotAlongTheirEdges) {
    const Scene scene = scene_of({square(4, 2, 0)});
    const auto engine = make_engine(scene, "embree");
    const LoneSurfaces lone(scene, *engine);
    for (uint32_t k = 0; k < 32; ++k) EXPECT_TRUE(is_lone_at_last(lone, middle_of(k), 1e-4f)) << k;
    EXPECT_FALSE(is_lone_at_last(lone, middle_of(0), 0.2f));
    Hit beside_an_edge = middle_of(0);
    beside_an_edge.u = 0.001f;
    EXPECT_FALSE(is_lone_at_last(lone, beside_an_edge, 1e-4f));
}

TEST(LoneSurfaces, AreNotJudgedBeforeTheyAreAskedAboutSomeTimes) {
    const Scene scene = scene_of({square(1, 2, 0)});
    const auto engine = make_engine(scene, "embree");
    const LoneSurfaces lone(scene, *engine);
    EXPECT_FALSE(lone.is_lone(middle_of(0), 1e-4f));
    EXPECT_TRUE(is_lone_at_last(lone, middle_of(0), 1e-4f));
}

TEST(LoneSurfaces, AreNotThoseWithACopyOfAnyKind) {
    for (const Mesh& copy : {square(1, 2, 0), flipped(square(1, 2, 0)), square(7, 2, 1e-7f)})
        for (const char* name : {"embree", "few-shapes"}) {
            const Scene scene = scene_of({square(1, 2, 0), copy});
            if (name == std::string("few-shapes") && copy.triangles.size() > 2) continue;
            const auto engine = make_engine(scene, name);
            const LoneSurfaces lone(scene, *engine);
            for (const uint32_t geometry : {0u, 1u})
                EXPECT_FALSE(is_lone_at_last(lone, middle_of(0, geometry), 1e-5f)) << name;
        }
}

TEST(LoneSurfaces, AreShapesWhoseBoxNothingMeets) {
    const auto lone_above = [](float floor) {
        Scene scene = scene_of({quad_mesh({-4, floor, 4}, {8, 0, 0}, {0, 0, -8})}, {Shape{}});
        const auto engine = make_engine(scene, "few-shapes");
        return is_lone_at_last(LoneSurfaces(scene, *engine), {1, 0, 0, 0, 1, 0}, 1e-4f);
    };
    EXPECT_TRUE(lone_above(-0.6f));
    EXPECT_FALSE(lone_above(-0.5f));
    EXPECT_FALSE(lone_above(0));
}

}  // namespace
}  // namespace sightline
