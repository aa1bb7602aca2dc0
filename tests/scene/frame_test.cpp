#include "scene/frame.h"

#include "support/gltf.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

Box3d cube(const Vec3d& centre, double half) {
    return {centre - Vec3d(half), centre + Vec3d(half)};
}

TEST(Frame, IsTheIdentityUnlessTheSceneIsFarTinyOrHuge) {
    EXPECT_TRUE(choose_frame({}).is_identity());
    EXPECT_TRUE(choose_frame(cube({1e9, 0, 0}, 0)).is_identity());  // a point has no size
    for (const double size : {3e-5, 1e-3, 1.0, 1e6, 5e8}) {
        SCOPED_TRACE(size);
        EXPECT_TRUE(choose_frame(cube({0, 0, 0}, size)).is_identity());
        EXPECT_TRUE(choose_frame(cube({63 * size, 0, 90 * size}, size)).is_identity());
        EXPECT_FALSE(choose_frame(cube({63 * size, 0, 93 * size}, size)).is_identity());
    }
}

TEST(Frame, OfAFarSceneHasItsOriginOnACoarseGridNearTheCentre) {
    const Vec3d centre(4195693.3, 1171018.7, 4646994.1);
    const Frame frame = choose_frame(cube(centre, 3));
    EXPECT_EQ(frame.scale, 1);
    EXPECT_EQ(frame.origin, choose_frame(cube(centre + Vec3d(0.1), 3.01)).origin);
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(std::fmod(frame.origin[i], 8), 0);
        EXPECT_LE(std::abs(frame.origin[i] - centre[i]), 4);
    }
}

TEST(Frame, OfATinyOrHugeSceneHasAPowerOfTwoAsScale) {
    for (const double size : {1e-18, 1e-15, 1e-11, 5e-6, 1e10, 1e15}) {
        SCOPED_TRACE(size);
        const Frame frame = choose_frame(cube({0, 0, 0}, size));
        EXPECT_EQ(frame.scale, std::exp2(std::round(std::log2(frame.scale))));
        const double radius = std::sqrt(3) * size * frame.scale;
        EXPECT_GE(radius, size < 1 ? 1 : 0x1p29);
        EXPECT_LT(radius, size < 1 ? 2 : 0x1p30);
    }
}

TEST(Frame, EntersAndLeavesByItsMatrices) {
    const Frame frame{{1024, -512, 0}, 0x1p-10};
    const Vec3d p(1025, 3, 7);
    EXPECT_EQ(frame.enter(p), transform_point(p, frame.to_frame()));
    EXPECT_EQ(frame.leave(frame.enter(p)), p);
    EXPECT_EQ(transform_point(frame.enter(p), frame.from_frame()), p);
}

// Seen from an animated part, or at another time, everything must keep its place.
TEST(Frame, OfAnAssetIsTheSameAtAllTimes) {
    GltfBuilder file;
    file.triangle();
    file.json["nodes"][0]["translation"] = {500000, 5400000, 0};
    file.json["animations"] = {
        {{"samplers",
          {{{"input", file.floats({0, 1}, "SCALAR")},
            {"output", file.floats({5e5f, 5.4e6f, 0, 6e5f, 5.4e6f, 9}, "VEC3")}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
    const std::string path = file.save();
    const Frame rest = load_gltf(path).frame;
    EXPECT_EQ(rest.origin, Vec3d(500001, 5400001, 0));  // a grid of 1 at (0.5, 0.5, 0)
    for (const float time : {0.0f, 0.5f, 1.0f}) {
        LoadOptions options;
        options.time = time;
        EXPECT_EQ(load_gltf(path, options).frame.origin, rest.origin);
    }
}

}  // namespace
}  // namespace sightline
