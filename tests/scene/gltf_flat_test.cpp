// Matrices that flatten what they transform, with and without instances.
#include "intersect/engines.h"
#include "support/gltf.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

using nlohmann::json;

/// A unit square in the plane of x and z that faces up, with normals, and a node that draws it.
GltfBuilder square() {
    GltfBuilder file;
    file.mesh_node({{"attributes",
                     {{"POSITION", file.floats({0, 0, 0, 0, 0, 1, 1, 0, 1, 1, 0, 0}, "VEC3")},
                      {"NORMAL", file.floats({0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0}, "VEC3")}}},
                    {"indices", file.indices({0, 1, 2, 0, 2, 3})}});
    return file;
}

/// The hits of rays straight down from y = 5 at these places on x, z = 0.25.
std::vector<Hit> hits_from_above(const Scene& scene, const std::vector<float>& places) {
    std::vector<Ray> rays;
    for (const float x : places) rays.push_back({.origin = {x, 5, 0.25f}, .direction = {0, -1, 0}});
    std::vector<Hit> hits(rays.size());
    make_engine(scene, "embree")->closest(rays, hits, Coherence::incoherent);
    return hits;
}

TEST(GltfFlat, AMeshUsedTwiceIsDrawnFlatWhereOneAxisIsScaledToNothing) {
    GltfBuilder file = square();
    file.add("nodes", {{"mesh", 0}, {"translation", {2, 1, 0}}, {"scale", {1, 0, 1}}});
    file.add("nodes", {{"mesh", 0}, {"translation", {4, 2, 0}}, {"scale", {1, 1e-30, 1}}});
    file.add("nodes", {{"mesh", 0}, {"translation", {6, 3, 0}}});
    const Scene scene = load_gltf(file.save());
    EXPECT_TRUE(scene.warnings.empty());
    const auto hits = hits_from_above(scene, {0.5f, 2.5f, 4.5f, 6.5f});
    for (size_t i = 0; i < hits.size(); ++i)
        EXPECT_NEAR(hits[i].t, 5 - static_cast<float>(i), 1e-5f) << i;
    for (const Mesh& mesh : scene.meshes)
        for (const Vec3& n : mesh.normals) EXPECT_EQ(n, Vec3(0, 1, 0));
    EXPECT_FALSE(scene.instances[hits[0].instance].baked);
    EXPECT_FALSE(scene.instances[hits[3].instance].baked);
}

TEST(GltfFlat, InstancesOfOneNodeAreDrawnFlat) {
    GltfBuilder file = square();
    file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", file.floats({0, 0, 0, 2, 1, 0, 4, 2, 0}, "VEC3")},
        {"SCALE", file.floats({1, 0, 1, 1, 0, 1, 1, 1, 1}, "VEC3")}};
    const auto hits = hits_from_above(load_gltf(file.save()), {0.5f, 2.5f, 4.5f});
    for (size_t i = 0; i < hits.size(); ++i)
        EXPECT_NEAR(hits[i].t, 5 - static_cast<float>(i), 1e-5f) << i;
}

// A square that was turned before a parent presses it: the product's determinant is rounding, which
// must not decide on which side its front lies.
TEST(GltfFlat, ATurnedChildOfAFlatParentKeepsItsFrontAndItsNormals) {
    for (int degrees = 5; degrees < 90; degrees += 5) {
        SCOPED_TRACE(degrees);
        const double half = degrees * 3.14159265358979 / 360;
        GltfBuilder file = square();
        file.json["nodes"][0]["rotation"] = {0, 0, std::sin(half), std::cos(half)};
        file.add("nodes",
                 {{"children", {0}}, {"scale", {1, 0, 1}}, {"rotation", {0, 0.6, 0, 0.8}}});
        const Scene scene = load_gltf(file.save());
        const Mesh& mesh = scene.meshes.at(0);
        const auto [a, b, c] = mesh.triangles.at(0);
        const Vec3& p = mesh.positions[a];
        EXPECT_GT(cross(mesh.positions[b] - p, mesh.positions[c] - p).y, 0);
        EXPECT_NEAR(mesh.normals[a].y, 1, 1e-6f);
        EXPECT_LE(std::abs(p.y), 1e-7f);
    }
}

TEST(GltfFlat, WhatIsScaledToALineOrAPointIsNotDrawnAndNamed) {
    for (const json& scale : {json{0, 0, 1}, json{0, 0, 0}}) {
        GltfBuilder file = square();
        file.json["nodes"][0]["scale"] = scale;
        const Scene one = load_gltf(file.save());
        EXPECT_TRUE(one.instances.empty());
        file.add("nodes", {{"mesh", 0}});
        const Scene two = load_gltf(file.save());
        EXPECT_EQ(two.instances.size(), 1u);
        for (const Scene* scene : {&one, &two}) {
            ASSERT_EQ(scene->warnings.size(), 1u);
            EXPECT_EQ(scene->warnings[0], "nodes[0]: is scaled to a line or a point: not drawn");
        }
    }
}

TEST(GltfFlat, CustomAttributesAloneMakeInstances) {
    GltfBuilder file = square();
    json& attributes = file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    attributes = {{"_ID", file.floats({7, 8, 9}, "SCALAR")},
                  {"_TINT", file.floats({0, 0, 0, 1, 1, 1, 0, 0, 1}, "VEC3")}};
    EXPECT_EQ(load_gltf(file.save()).instances.size(), 3u);
    attributes["_OTHER"] = file.floats({1, 2}, "SCALAR");
    EXPECT_TRUE(fails(file.save(), "attributes._OTHER: 2 instances, but 3 elsewhere"));
    attributes = json::object();
    const Scene scene = load_gltf(file.save());
    EXPECT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(scene.warnings.size(), 1u);
}

}  // namespace
}  // namespace sightline
