#include "scene/tangents.h"

#include "scene/gltf/load.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

namespace sightline {
namespace {

/// A grid of n × n squares over the unit square of uv; v grows downwards.
template <class Position, class Normal>
Mesh grid(uint32_t n, const Position& position, const Normal& normal) {
    Mesh mesh;
    mesh.texcoords.resize(1);
    for (uint32_t j = 0; j <= n; ++j) {
        for (uint32_t i = 0; i <= n; ++i) {
            const Vec2 uv(float(i) / float(n), float(j) / float(n));
            mesh.texcoords[0].push_back(uv);
            mesh.positions.push_back(position(uv));
            mesh.normals.push_back(normal(uv));
            if (i == n || j == n) continue;
            const uint32_t a = j * (n + 1) + i, b = a + n + 1;
            mesh.triangles.push_back({a, b, a + 1});
            mesh.triangles.push_back({a + 1, b, b + 1});
        }
    }
    return mesh;
}

Mesh plane(uint32_t n) {
    return grid(
        n, [](const Vec2& uv) { return Vec3(uv.x, -uv.y, 0); },
        [](const Vec2&) { return Vec3(0, 0, 1); });
}

void expect_near(const Vec4& found, const Vec4& expected, float tolerance = 1e-6f) {
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(found[i], expected[i], tolerance) << i;
}

TEST(Tangents, OfAPlanePointAlongUWithTheBitangentUp) {
    Mesh mesh = plane(3);
    compute_tangents(mesh, 0);
    ASSERT_EQ(mesh.tangents.size(), 16u);
    for (const Vec4& tangent : mesh.tangents) expect_near(tangent, {1, 0, 0, 1});
}

TEST(Tangents, FollowRotatedAndScaledTextureCoordinates) {
    Mesh mesh = plane(1);
    for (Vec2& uv : mesh.texcoords[0]) uv = Vec2(5 * uv.y, -uv.x);
    compute_tangents(mesh, 0);
    for (const Vec4& tangent : mesh.tangents) expect_near(tangent, {0, -1, 0, 1});
}

TEST(Tangents, MirroredTextureCoordinatesFlipTheBitangentAndSplitTheirSeam) {
    Mesh mesh = plane(2);
    for (Vec2& uv : mesh.texcoords[0]) uv.x = std::abs(uv.x - 0.5f);
    mesh.colors.assign(9, Vec4(1));
    mesh.colors[4] = Vec4(0.5f);
    compute_tangents(mesh, 0);
    EXPECT_EQ(mesh.positions.size(), 12u);  // the seam's three vertices twice
    EXPECT_EQ(mesh.colors.size(), 12u);
    EXPECT_EQ(std::ranges::count(mesh.colors, Vec4(0.5f)), 2);
    for (const auto& triangle : mesh.triangles) {
        const float middle = (mesh.positions[triangle[0]].x + mesh.positions[triangle[1]].x +
                              mesh.positions[triangle[2]].x) /
                             3;
        for (const uint32_t v : triangle)
            expect_near(mesh.tangents[v], middle < 0.5f ? Vec4(-1, 0, 0, -1) : Vec4(1, 0, 0, 1));
    }
}

TEST(Tangents, OfASphereAreItsParallels) {
    const auto point = [](const Vec2& uv) {
        const float longitude = 2 * pi * uv.x, latitude = pi * uv.y;
        return Vec3(std::sin(latitude) * std::sin(longitude), std::cos(latitude),
                    std::sin(latitude) * std::cos(longitude));
    };
    Mesh mesh = grid(64, point, point);
    compute_tangents(mesh, 0);
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3& p = mesh.positions[v];
        const float across = std::sqrt(p.x * p.x + p.z * p.z);
        if (across < 0.1f) continue;
        const Vec2& uv = mesh.texcoords[0][v];
        // Half of a seam's or pole row's triangles lie on one side only.
        const bool border = uv.x == 0 || uv.x == 1;
        expect_near(mesh.tangents[v], {p.z / across, 0, -p.x / across, 1}, border ? 0.06f : 5e-3f);
    }
}

TEST(Tangents, AreWeightedByAngleNotByTriangulation) {
    // Left of the y axis u grows along x, right of it along (1, 0.5); the right side is cut in two.
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {0, -1, 0}, {-1, 0, 0}, {1, 0, 0}, {0.5f, -0.5f, 0}};
    mesh.normals.assign(5, {0, 0, 1});
    mesh.texcoords = {{{0, 0}, {0, 1}, {-1, 0}, {1, 0.5f}, {0.5f, 0.75f}}};
    mesh.triangles = {{0, 2, 1}, {0, 4, 3}, {0, 1, 4}};
    compute_tangents(mesh, 0);
    const Vec3 right = normalize(Vec3(1, 0.5f, 0)), mean = normalize(Vec3(1, 0, 0) + right);
    expect_near(mesh.tangents[0], {mean.x, mean.y, 0, 1});
    expect_near(mesh.tangents[2], {1, 0, 0, 1});
    expect_near(mesh.tangents[3], {right.x, right.y, 0, 1});
}

TEST(Tangents, SurviveDegenerateTrianglesAndTextureCoordinates) {
    Mesh mesh = plane(2);
    mesh.triangles.push_back({4, 4, 5});
    for (const size_t v : {0u, 1u, 3u}) mesh.texcoords[0][v] = Vec2(0.25f);  // no area
    mesh.positions.push_back({9, 9, 9});                                     // used by nothing
    mesh.normals.push_back({1, 0, 0});
    mesh.texcoords[0].push_back({0, 0});
    compute_tangents(mesh, 0);
    for (size_t v = 0; v < mesh.tangents.size(); ++v) {
        const Vec4& t = mesh.tangents[v];
        const Vec3 tangent(t.x, t.y, t.z);
        EXPECT_NEAR(dot(tangent, tangent), 1, 1e-5f) << v;
        EXPECT_NEAR(dot(tangent, mesh.normals[v]), 0, 1e-5f) << v;
        EXPECT_EQ(std::abs(t.w), 1);
    }
    EXPECT_EQ(mesh.triangles.back(), (std::array<uint32_t, 3>{4, 4, 5}));  // borrows theirs

    Mesh blank = plane(1);
    for (Vec2& uv : blank.texcoords[0]) uv = Vec2(NAN, 0.5f);
    compute_tangents(blank, 0);
    for (const Vec4& t : blank.tangents) EXPECT_NEAR(dot(Vec3(t.x, t.y, t.z), Vec3(0, 0, 1)), 0, 0);

    Mesh empty;
    empty.texcoords.resize(1);
    compute_tangents(empty, 0);
    EXPECT_TRUE(empty.tangents.empty());
}

TEST(Tangents, DoNotDependOnHowVerticesAreShared) {
    const auto height = [](const Vec2& uv) { return Vec3(uv.x, -uv.y, uv.x * uv.y); };
    const auto normal = [](const Vec2& uv) { return normalize(Vec3(-uv.y, uv.x, 1)); };
    Mesh shared = grid(4, height, normal), apart = shared;
    apart.positions.clear();
    apart.normals.clear();
    apart.texcoords[0].clear();
    for (auto& triangle : apart.triangles) {
        for (uint32_t& v : triangle) {
            apart.positions.push_back(shared.positions[v]);
            apart.normals.push_back(shared.normals[v]);
            apart.texcoords[0].push_back(shared.texcoords[0][v]);
            v = static_cast<uint32_t>(apart.positions.size() - 1);
        }
    }
    compute_tangents(shared, 0);
    compute_tangents(apart, 0);
    for (size_t t = 0; t < shared.triangles.size(); ++t)
        for (size_t i = 0; i < 3; ++i)
            EXPECT_EQ(shared.tangents[shared.triangles[t][i]],
                      apart.tangents[apart.triangles[t][i]]);
}

TEST(Tangents, EqualThoseOfOtherToolsWithTheSameRules) {
    const std::string models =
        SIGHTLINE_SOURCE_DIR "/../shared/corpus/valid/DRx3D_glTF-Sample-Assets/Models/";
    if (!std::filesystem::exists(models)) GTEST_SKIP() << "no corpus at " << models;
    LoadOptions options;
    options.decode_images = false;
    for (const char* name : {"AnisotropyStrengthTest", "AlphaBlendModeTest"}) {
        const Scene scene = load_gltf(models + name + "/glTF/" + name + ".gltf", options);
        size_t checked = 0;
        for (const Mesh& authored : scene.meshes) {
            if (authored.tangents.empty()) continue;
            Mesh mesh = authored;
            compute_tangents(mesh, 0);
            for (size_t t = 0; t < mesh.triangles.size(); ++t) {
                for (size_t i = 0; i < 3; ++i, ++checked) {
                    const Vec4 expected = authored.tangents[authored.triangles[t][i]];
                    ASSERT_GT(mesh.tangents[mesh.triangles[t][i]].dot(expected), 1.999f);
                }
            }
        }
        EXPECT_GE(checked, 90u) << name;  // corners with a normal map over them
    }
}

TEST(FlatNormals, AreTheTrianglesOwn) {
    Mesh mesh = grid(
        1, [](const Vec2& uv) { return Vec3(uv.x, -uv.y, uv.x * uv.y); },
        [](const Vec2&) { return Vec3(1, 0, 0); });
    mesh.triangles.push_back({0, 0, 1});
    compute_flat_normals(mesh);
    ASSERT_EQ(mesh.positions.size(), 9u);
    ASSERT_EQ(mesh.texcoords[0].size(), 9u);
    EXPECT_EQ(mesh.triangles[1], (std::array<uint32_t, 3>{3, 4, 5}));
    for (size_t v = 0; v < 3; ++v) EXPECT_EQ(mesh.normals[v], Vec3(0, 0, 1));
    const Vec3 expected = normalize(Vec3(-1, 1, 1));
    EXPECT_NEAR((mesh.normals[4] - expected).length(), 0, 1e-6f);
    EXPECT_NEAR(mesh.normals[8].length(), 1, 1e-6f);
}

}  // namespace
}  // namespace sightline
