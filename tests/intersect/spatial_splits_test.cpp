// Long diagonal triangles in several boxes: fewer tests, and the same answers.
#include "intersect/bvh/spatial_splits.h"
#include "exact/referee.h"
#include "intersect/exact/hit_query.h"
#include "support/rays.h"
#include "support/scenes.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

/// Thin cables of three sides from one half of the cube [−10, 10]³ to the other.
Mesh cables(int count) {
    Mesh mesh;
    TestRandom random;
    for (int i = 0; i < count; ++i) {
        const Vec3 from = random.vector(10), to = random.vector(10);
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        for (const Vec3& end : {from, to})
            for (const Vec3& side : {Vec3(0.02f, 0, 0), Vec3(0, 0.02f, 0), Vec3(0, 0, 0.02f)})
                mesh.positions.push_back(end + side);
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t a = first + k, b = first + (k + 1) % 3;
            mesh.triangles.push_back({a, b, a + 3});
            mesh.triangles.push_back({b, b + 3, a + 3});
        }
    }
    return mesh;
}

std::vector<Ray> rays_through(const Mesh& mesh, int count) {
    TestRandom random;
    std::vector<Ray> rays;
    for (int i = 0; i < count; ++i)
        for (const Aim aim : {Aim::anywhere, Aim::edge, Aim::vertex})
            rays.push_back(aimed_ray(mesh, aim, random, {0, 0, 0}, 10));
    return rays;
}

/// Nodes and blocks of eight that a line enters.
struct Visits {
    size_t nodes = 0, blocks = 0;

    void count(const Bvh& bvh, NodeRef child, const Ray& ray) {
        if (child.is_leaf()) {
            blocks += child.count();
            return;
        }
        ++nodes;
        const BvhNode& node = bvh.nodes[child.index()];
        for (size_t i = 0; i < 8; ++i)
            if (!node.children[i].is_nothing() && enters(node, i, ray))
                count(bvh, node.children[i], ray);
    }

  private:
    static bool enters(const BvhNode& node, size_t child, const Ray& ray) {
        float near = 0, far = std::numeric_limits<float>::infinity();
        for (int axis = 0; axis < 3; ++axis) {
            const float a = (node.planes[2 * axis][child] - ray.origin[axis]) / ray.direction[axis];
            const float b =
                (node.planes[2 * axis + 1][child] - ray.origin[axis]) / ray.direction[axis];
            near = std::max(near, std::min(a, b));
            far = std::min(far, std::max(a, b));
        }
        return near <= far;
    }
};

Visits visits(const TwoLevelBvh& bvh, const std::vector<Ray>& rays) {
    Visits sum;
    const Bvh& baked = bvh.baked.triangles.bvh;
    for (const Ray& ray : rays) sum.count(baked, baked.root, ray);
    return sum;
}

template <class Query>
Query search(const TwoLevelBvh& bvh, const Ray& ray) {
    Query query(bvh, ray, Visible::all);
    TraversalLimits limits = query.initial_limits();
    const TriangleBvh& baked = bvh.baked.triangles;
    if (query.begin(limits)) return query;
    const TraversalRay traversal_ray(query.world_ray(), baked.bvh, baked.max_edge);
    query.finish(limits, traverse(baked, traversal_ray, limits, query));
    return query;
}

// A block costs as much as two nodes.
TEST(SpatialSplits, SaveAFifthOfTheWorkOnLongDiagonalTriangles) {
    const Scene scene = scene_of({cables(1000)});
    const TwoLevelBvh split(scene), whole(scene, false);
    const std::vector<Ray> rays = rays_through(scene.meshes[0], 300);
    const Visits with = visits(split, rays), without = visits(whole, rays);
    EXPECT_LT(100 * with.blocks, 78 * without.blocks);
    EXPECT_LT(10 * (with.nodes + 2 * with.blocks), 8 * (without.nodes + 2 * without.blocks));
    EXPECT_LT(10 * split.memory(), 14 * whole.memory());
}

TEST(SpatialSplits, AreNotUsedInOrdinaryScenes) {
    for (const Scene& scene : {scene_of({globe(64)}), scene_of({cables(10)})}) {
        EXPECT_EQ(TwoLevelBvh(scene).baked.triangles.blocks.size(),
                  TwoLevelBvh(scene, false).baked.triangles.blocks.size());
    }
}

TEST(SpatialSplits, ChangeNoBitOfAnyAnswer) {
    const Scene scene = scene_of({cables(1000)});
    const TwoLevelBvh split(scene), whole(scene, false);
    ASSERT_GT(split.baked.triangles.blocks.size(), whole.baked.triangles.blocks.size());
    const Referee referee(scene);
    int hits = 0;
    for (const Ray& ray : rays_through(scene.meshes[0], 700)) {
        const Hit hit = search<ClosestHitQuery>(split, ray).hit();
        const Hit expected = search<ClosestHitQuery>(whole, ray).hit();
        EXPECT_EQ(surface_of(hit), surface_of(expected));
        EXPECT_EQ(hit.t, expected.t);
        EXPECT_EQ(hit.u, expected.u);
        EXPECT_EQ(hit.v, expected.v);
        EXPECT_EQ(search<AnyHitQuery>(split, ray).occluded(), bool(hit));
        const Truth truth = referee.closest(ray);
        EXPECT_EQ(bool(hit), !truth.nearest.empty());
        if (!hit || truth.nearest.empty()) continue;
        EXPECT_EQ(surface_of(hit), truth.nearest.front());
        ++hits;
    }
    EXPECT_GT(hits, 1400);
}

/// All numbers here are small multiples of 2^-16, so that points within the triangles are exact.
TEST(SpatialSplits, KeepEveryPointOfATriangleInOneOfItsBoxes) {
    TestRandom random;
    std::vector<Corners<float>> triangles;
    std::vector<Box3> boxes;
    std::vector<uint32_t> numbers;
    const auto point = [&] {
        const auto coordinate = [&] { return std::round(random.between(-512, 512)) / 512; };
        return Vec3(coordinate(), coordinate(), coordinate());
    };
    for (uint32_t i = 0; i < 500; ++i) {
        const Vec3 a = point();
        const Corners<float> triangle = {a, point(), i % 2 ? point() : a + Vec3(0x1p-9f, 0, 0)};
        Box3 box(triangle.a);
        box.extendBy(triangle.b);
        box.extendBy(triangle.c);
        triangles.push_back(triangle);
        boxes.push_back(box);
        numbers.push_back(i);
    }
    split_boxes(boxes, numbers, [&](uint32_t number) { return triangles[number]; });
    EXPECT_GT(boxes.size(), 550u);
    EXPECT_LE(boxes.size(), 650u);
    ASSERT_EQ(boxes.size(), numbers.size());
    std::vector<std::vector<Box3>> of_triangle(triangles.size());
    for (size_t i = 0; i < boxes.size(); ++i) of_triangle[numbers[i]].push_back(boxes[i]);
    size_t lost = 0;
    for (size_t i = 0; i < triangles.size(); ++i)
        for (int u = 0; u <= 64; ++u)
            for (int v = 0; u + v <= 64; ++v) {
                const auto& [a, b, c] = triangles[i];
                const Vec3 p = (a * static_cast<float>(64 - u - v) + b * static_cast<float>(u) +
                                c * static_cast<float>(v)) /
                               64.0f;
                lost += std::none_of(of_triangle[i].begin(), of_triangle[i].end(),
                                     [&](const Box3& box) { return box.intersects(p); });
            }
    EXPECT_EQ(lost, 0u);
}

TEST(SpatialSplits, TolerateTrianglesWithoutExtent) {
    std::vector<Box3> boxes(3, Box3(Vec3(1, 2, 3)));
    std::vector<uint32_t> numbers = {0, 1, 2};
    split_boxes(boxes, numbers, [](uint32_t) {
        return Corners<float>{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}};
    });
    EXPECT_EQ(boxes.size(), 3u);
    boxes.clear();
    numbers.clear();
    split_boxes(boxes, numbers, nullptr);
    EXPECT_TRUE(boxes.empty());
}

}  // namespace
}  // namespace sightline
