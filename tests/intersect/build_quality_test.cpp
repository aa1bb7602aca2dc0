#include "intersect/embree/build_quality.h"

#include "support/rays.h"
#include "support/scenes.h"

#include <gtest/gtest.h>

#include <cstring>

namespace sightline {
namespace {

/// Flat strips of `length` along `direction`, at random places of the cube [−10, 10]³.
Mesh strips(int count, const Vec3& direction, float length, float width) {
    Mesh mesh;
    std::mt19937 random(2);
    const Vec3 along = normalize(direction) * length;
    const Vec3 across = normalize(cross(direction, Vec3(0.3f, 1, 0.2f))) * width;
    for (int i = 0; i < count; ++i) {
        const Vec3 start = random_point(random) * 10.0f - along * 0.5f;
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        for (const Vec3& corner : {start, start + along, start + along + across, start + across})
            mesh.positions.push_back(corner);
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
    }
    return mesh;
}

TEST(BuildQuality, LongDiagonalTrianglesGetSpatialSplits) {
    EXPECT_EQ(choose_build_quality(scene_of({strips(2000, {6, 5, 4}, 12, 0.03f)})),
              BuildQuality::high);
}

TEST(BuildQuality, LongDiagonalTrianglesOfAnInstancedGroupGetSpatialSplits) {
    Mat4 there;
    there.setTranslation(Vec3(1000, 0, 0));
    SceneBuilder builder;
    builder.add_instance(builder.add_mesh(sphere_mesh(16, 16)));
    const uint32_t cables = builder.add_mesh(strips(2000, {6, 5, 4}, 12, 0.03f));
    builder.add_instance(cables, Mat4());
    builder.add_instance(cables, there);
    EXPECT_EQ(choose_build_quality(builder.finish()), BuildQuality::high);
}

TEST(BuildQuality, OtherMeshesGetNoSpatialSplits) {
    EXPECT_EQ(choose_build_quality(empty_scene()), BuildQuality::medium);
    EXPECT_EQ(choose_build_quality(scene_of({sphere_mesh(64, 64)})), BuildQuality::medium);
    const Mesh along_an_axis = strips(2000, {1, 0, 0}, 12, 0.03f);
    const Mesh foliage = strips(50000, {6, 5, 4}, 0.4f, 0.3f);
    const Mesh needles = strips(2000, {6, 5, 4}, 0.1f, 0.0003f);
    const Mesh few = strips(20, {6, 5, 4}, 12, 0.03f);
    EXPECT_EQ(choose_build_quality(scene_of({along_an_axis})), BuildQuality::medium);
    EXPECT_EQ(choose_build_quality(scene_of({foliage})), BuildQuality::medium);
    EXPECT_EQ(choose_build_quality(scene_of({needles})), BuildQuality::medium);
    EXPECT_EQ(choose_build_quality(scene_of({few})), BuildQuality::medium);
}

TEST(BuildQuality, AreaRatioComparesBoxesWithThoseOfFlatTriangles) {
    const OverlapStats flat = overlap_stats(scene_of({triangle_mesh(0)}));
    EXPECT_DOUBLE_EQ(flat.boxes_entered, 1);
    EXPECT_DOUBLE_EQ(flat.area_ratio, 1);
    Mesh diagonal;
    diagonal.positions = {{0, 0, 0}, {1, 1, 1}, {0, 0, 1}};
    diagonal.triangles = {{0, 1, 2}};
    EXPECT_NEAR(overlap_stats(scene_of({diagonal})).area_ratio, 3 / std::sqrt(2.0), 1e-6);
}

TEST(BuildQuality, EmbreesSplitsHaveAnEffectInTheDefaultModeOnly) {
    const Scene scene = scene_of({strips(2000, {6, 5, 4}, 12, 0.03f)});
    for (const bool robust : {false, true}) {
        const auto plain = make_embree(scene, {.robust = robust});
        const auto split = make_embree(scene, {.robust = robust, .quality = BuildQuality::high});
        EXPECT_EQ(split->memory() > plain->memory() * 5 / 4, !robust);
        EXPECT_EQ(split->description().find("splits") != std::string::npos, !robust);
        std::mt19937 random(4);
        std::vector<Ray> rays(5000);
        for (Ray& ray : rays) ray = {random_point(random) * 10, 0, random_point(random), infinity};
        const auto expected = closest(*plain, rays), found = closest(*split, rays);
        for (size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(found[i].t, expected[i].t);
    }
}

}  // namespace
}  // namespace sightline
