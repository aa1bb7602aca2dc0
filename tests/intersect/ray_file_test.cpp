// Ray files and ray literals, valid and invalid.
#include "intersect/ray_file.h"

#include "core/error.h"
#include "scene/geometry_hash.h"
#include "support/scenes.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstring>
#include <fstream>

namespace sightline {
namespace {

const std::vector<RecordedRay> some_rays = {
    {{{1, 2, 3}, 0, {0, 0, -1}}, RayKind::camera, -1, -1, {}},
    {{{NAN, 2, 3}, -1, {0, 0, 0}, 0.1f}, RayKind::refraction, -1, -1, {1, 2, 3}}};

Scene some_scene() {
    Scene scene = scene_of({globe(4)});
    scene.frame = {{1e6, 2, 3}, 4};
    return scene;
}

std::array<uint32_t, 8> bits_of(const Ray& r) {
    const std::array<float, 8> values{r.origin.x,    r.origin.y,    r.origin.z,    r.tnear,
                                      r.direction.x, r.direction.y, r.direction.z, r.tfar};
    std::array<uint32_t, 8> bits{};
    for (size_t i = 0; i < bits.size(); ++i) bits[i] = std::bit_cast<uint32_t>(values[i]);
    return bits;
}

std::string write(const std::string& bytes) {
    std::string path = (test_folder() / "rays").string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
}

std::string good_bytes() {
    const std::string path = (test_folder() / "good").string();
    write_rays(path, some_rays, some_scene());
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::string message_of(const std::string& bytes) {
    try {
        read_rays(write(bytes));
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

TEST(RayFile, RoundTripPreservesEveryBit) {
    const RayFile file = read_rays(write(good_bytes()));
    EXPECT_EQ(file.geometry_hash, hash_geometry(some_scene()));
    EXPECT_EQ(file.frame.origin, Vec3d(1e6, 2, 3));
    EXPECT_EQ(file.frame.scale, 4);
    const auto& rays = file.rays;
    ASSERT_EQ(rays.size(), 2u);
    for (size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(bits_of(rays[i].ray), bits_of(some_rays[i].ray));
        EXPECT_EQ(rays[i].kind, some_rays[i].kind);
        EXPECT_EQ(rays[i].source, some_rays[i].source);
        EXPECT_LT(rays[i].x, 0);
    }
}

TEST(RayFile, EveryTruncationIsAnError) {
    const std::string bytes = good_bytes();
    for (size_t length = 0; length < bytes.size(); ++length)
        EXPECT_NE(message_of(bytes.substr(0, length)), "") << length;
    EXPECT_NE(message_of(bytes + "x"), "");
}

TEST(RayFile, AnotherFormatVersionCountOrKindIsAnErrorThatNamesIt) {
    std::string bytes = good_bytes();
    bytes[6] = '3';
    EXPECT_NE(message_of(bytes).find("another version"), std::string::npos);
    bytes[0] = 'x';
    EXPECT_NE(message_of(bytes).find("not a ray file"), std::string::npos);
    for (const uint64_t count :
         {uint64_t{0}, uint64_t{1}, uint64_t{3}, UINT64_MAX, UINT64_MAX / 48}) {
        bytes = good_bytes();
        std::memcpy(bytes.data() + 8, &count, 8);
        EXPECT_NE(message_of(bytes).find("declares"), std::string::npos) << count;
    }
    bytes = good_bytes();
    bytes[64 + 32] = 4;
    EXPECT_NE(message_of(bytes).find("ray 0 is of the unknown kind 4"), std::string::npos);
    EXPECT_THROW(read_rays((test_folder() / "nothing").string()), Error);
    EXPECT_THROW(read_rays(test_folder().string()), Error);
}

TEST(RayFile, AFileWithoutRaysIsValid) {
    EXPECT_TRUE(read_rays(write(std::string("SLRAYS2\n") + std::string(56, '\0'))).rays.empty());
}

TEST(RayFile, VersionOneIsReadWithoutSceneAndSources) {
    std::string bytes("SLRAYS1\n\1\0\0\0\0\0\0\0", 16);
    bytes.append(reinterpret_cast<const char*>(&some_rays[0].ray), sizeof(Ray));
    const RayKind kind = RayKind::shadow;
    bytes.append(reinterpret_cast<const char*>(&kind), sizeof kind);
    const RayFile file = read_rays(write(bytes));
    ASSERT_EQ(file.rays.size(), 1u);
    EXPECT_EQ(bits_of(file.rays[0].ray), bits_of(some_rays[0].ray));
    EXPECT_EQ(file.rays[0].kind, RayKind::shadow);
    EXPECT_EQ(file.rays[0].source, SurfaceId());
    EXPECT_FALSE(file.geometry_hash);
    EXPECT_TRUE(file.frame.is_identity());
    EXPECT_NE(message_of(bytes.substr(0, 40)), "");
}

TEST(RayLiteral, RoundTripPreservesEveryBit) {
    for (const Ray& ray : {Ray{{1, -2, 0.1f}, 0, {1e-40f, 3e38f, -0.0f}},
                           Ray{{0, 0, 0}, -1, {0, 0, 0}, 0x1p-149f}}) {
        const Ray back = parse_ray(ray_literal(ray)).ray;
        EXPECT_EQ(bits_of(back), bits_of(ray)) << ray_literal(ray);
    }
    EXPECT_TRUE(std::isnan(parse_ray("nan,0,0,0,0,1,0,inf").ray.origin.x));
    EXPECT_EQ(parse_ray("1,2,3,0x1p-1,5,6,7,8").ray.direction.x, 0.5f);
}

TEST(RayLiteral, HoldsTheKindAndTheSurfaceThatTheRayLeaves) {
    const RecordedRay recorded{{{1, 2, 3}, 0, {0, 0, -1}}, RayKind::shadow, -1, -1, {4, 5, 6}};
    const RecordedRay back = parse_ray(ray_literal(recorded));
    EXPECT_EQ(back.kind, RayKind::shadow);
    EXPECT_EQ(back.source, (SurfaceId{4, 5, 6}));
    EXPECT_EQ(parse_ray("0,0,0,0,0,1,0,inf,reflection").kind, RayKind::reflection);
    EXPECT_EQ(parse_ray("0,0,0,0,0,1,0,inf,reflection").source, SurfaceId());
    EXPECT_EQ(parse_ray("0,0,0,0,0,1,0,inf").kind, RayKind::camera);
}

TEST(RayLiteral, AnyOtherTextIsInvalid) {
    for (const char* text : {"", "1,2,3", "1,2,3,4,5,6,7,8,9", "1,2,3,4,5,6,7,x", "a,2,3,4,5,6,7,8",
                             "1,2,3,4,5,6,7,8 ", "1,2,3,4,5,6,7,8,glow", "1,2,3,4,5,6,7,8,shadow,1",
                             "1,2,3,4,5,6,7,8,shadow,1,2,3,4", "1;2;3;4;5;6;7;8", "1,,3,4,5,6,7,8"})
        EXPECT_THROW(parse_ray(text), std::invalid_argument) << text;
}

}  // namespace
}  // namespace sightline
