// The mode that Embree gets for a scene, and whether the default mode is right if it is chosen.
#include "exact/referee.h"
#include "intersect/embree/robust_choice.h"
#include "support/pictures.h"

#include <random>

namespace sightline {
namespace {

/// Triangles with two sides of length 1 and `width`, at random in a cube of side 8, no two of which
/// share an edge.
Mesh confetti(float width, int count = 2000) {
    Mesh mesh;
    std::mt19937 random(6);
    std::uniform_real_distribution<float> number(-1, 1);
    const auto vector = [&] {
        const float x = number(random), y = number(random);
        return Vec3(x, y, number(random));
    };
    for (int i = 0; i < count; ++i) {
        const Vec3 centre = vector() * 4.0f, along = normalize(vector());
        const Vec3 across = normalize(cross(along, vector())) * width;
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {centre, centre + along, centre + across});
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

Scene mirror_scene(const Mesh& mesh) {
    Material mirror = matte({0.2f, 0.2f, 0.2f});
    mirror.metallic_factor = 1;
    mirror.roughness_factor = 0;
    mirror.base_color_factor = {0.9f, 0.9f, 0.9f, 1};
    SceneBuilder builder;
    draw(builder, mesh, mirror);
    builder.add_light(point_light({3, 7, 5}, 30));
    return builder.finish();
}

RenderSettings job_for(const Scene& scene) {
    return small_settings(fit_camera(scene.bounds), 4, 96, 96);
}

Needs needs_of(const Scene& scene) { return find_needs(scene, job_for(scene), false); }

std::string line(const Needs& needs, const std::string& name) {
    for (const Decision& decision : needs.report)
        if (decision.name == name) return decision.choice + ": " + decision.because;
    return "not reported";
}

/// Answers of Embree as `needs` has it that the referee calls wrong, over every ray of a render.
size_t wrong_answers(const Scene& scene) {
    const RenderSettings settings = job_for(scene);
    const Needs needs = find_needs(scene, settings, false);
    const RenderResult picture =
        render_scene(scene, settings, nullptr, &needs, {.record_rays = true, .stop = {}});
    const auto engine = make_embree(scene, needs.embree);
    const Referee referee(scene);
    size_t wrong = 0;
    std::vector<Ray> rays;
    for (const RecordedRay& recorded : picture.rays) rays.push_back(recorded.ray);
    std::vector<Hit> hits(rays.size());
    engine->closest(rays, hits, Coherence::incoherent);
    for (size_t i = 0; i < rays.size(); ++i) {
        wrong += is_wrong(referee.judge(rays[i], hits[i]));
    }
    EXPECT_GT(rays.size(), 30000u);
    return wrong;
}

TEST(EmbreeChoice, LooseTrianglesGetTheDefaultModeAndNoAnswerIsWrong) {
    const Scene scene = mirror_scene(confetti(0.5f));
    EXPECT_FALSE(needs_of(scene).embree.robust) << line(needs_of(scene), "embree_mode");
    EXPECT_EQ(wrong_answers(scene), 0u);
}

TEST(EmbreeChoice, ASharedEdgeNeedsRobust) {
    Mesh mesh = confetti(0.5f);
    mesh.positions.push_back(mesh.positions[1] + Vec3(0.3f, 0.2f, 0.7f));
    const auto last = static_cast<uint32_t>(mesh.positions.size() - 1);
    mesh.triangles.push_back({1, 0, last});
    const Needs needs = needs_of(mirror_scene(mesh));
    EXPECT_TRUE(needs.embree.robust);
    EXPECT_NE(line(needs, "embree_mode").find("T1e"), std::string::npos);
    EXPECT_TRUE(needs_of(mirror_scene(ball({0, 0, 0}, 1))).embree.robust);
}

TEST(EmbreeChoice, ASharedEdgeBetweenDuplicateVerticesNeedsRobust) {
    Mesh mesh = confetti(0.5f, 100);
    const Vec3 a = mesh.positions[0], b = mesh.positions[1];
    mesh.positions.insert(mesh.positions.end(), {b, a, a + Vec3(0.3f, 0.2f, 0.7f)});
    mesh.triangles.push_back({300, 301, 302});
    EXPECT_TRUE(needs_of(mirror_scene(mesh)).embree.robust);
}

TEST(EmbreeChoice, TrianglesThinnerThanTheSafeValueNeedRobust) {
    const double limit = max_safe_value("T2", "embree-default");
    ASSERT_GT(limit, 0);
    const auto knob = [&](const Scene& scene) {
        return triangle_stats(scene, job_for(scene).camera.to_world.translation())
            .max_coordinate_over_min_height;
    };
    float width = 0.5f;
    while (knob(mirror_scene(confetti(width / 2))) <= limit) width /= 2;
    const Scene safe = mirror_scene(confetti(width)), thin = mirror_scene(confetti(width / 2));
    EXPECT_FALSE(needs_of(safe).embree.robust);
    EXPECT_TRUE(needs_of(thin).embree.robust) << line(needs_of(thin), "embree_mode");
    EXPECT_EQ(wrong_answers(safe), 0u);
}

TEST(EmbreeChoice, DistantTrianglesNeedRobust) {
    Mesh mesh = confetti(0.5f);
    for (Vec3& p : mesh.positions) p.x += 1e4f;
    EXPECT_TRUE(needs_of(mirror_scene(mesh)).embree.robust);
}

TEST(EmbreeChoice, InstancesShapesAndTrianglesWithoutAreaNeedRobust) {
    Scene instanced = mirror_scene(confetti(0.5f));
    instanced.instances[0].baked = false;
    EXPECT_TRUE(needs_of(instanced).embree.robust);
    Scene shapes = mirror_scene(confetti(0.5f));
    shapes.shapes.emplace_back();
    shapes.groups[0].shapes.push_back(0);
    EXPECT_TRUE(needs_of(shapes).embree.robust);
    Mesh flat = confetti(0.5f);
    flat.positions[1] = flat.positions[0];
    EXPECT_TRUE(needs_of(mirror_scene(flat)).embree.robust);
}

TEST(EmbreeChoice, LooseLongDiagonalTrianglesGetSpatialSplits) {
    Mesh cables;
    std::mt19937 random(2);
    std::uniform_real_distribution<float> number(-10, 10);
    for (int i = 0; i < 4000; ++i) {
        const float x = number(random), y = number(random);
        const Vec3 start(x, y, number(random));
        const auto first = static_cast<uint32_t>(cables.positions.size());
        cables.positions.insert(cables.positions.end(),
                                {start, start + Vec3(9, 7, 6), start + Vec3(0.4f, 0.2f, 1)});
        cables.triangles.push_back({first, first + 1, first + 2});
    }
    const Needs split = needs_of(mirror_scene(cables)),
                plain = needs_of(mirror_scene(confetti(0.5f)));
    EXPECT_EQ(split.embree.quality, BuildQuality::high) << line(split, "spatial_splits");
    EXPECT_EQ(plain.embree.quality, BuildQuality::medium) << line(plain, "spatial_splits");
    EXPECT_EQ(line(needs_of(mirror_scene(ball({0, 0, 0}, 1))), "spatial_splits"), "not reported");
}

TEST(Breakdown, NothingUnmeasuredIsSafe) {
    EXPECT_EQ(max_safe_value("T2", "no such method"), 0);
    EXPECT_EQ(max_safe_value("no such family", "embree"), 0);
    EXPECT_GT(max_safe_value("T2", "exact"), 1e6);
    EXPECT_EQ(first_failing_value("T2", "exact"), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace sightline
