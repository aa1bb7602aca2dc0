#include "intersect/engines.h"
#include "shade/bsdf.h"
#include "support/surfaces.h"

#include <random>

namespace sightline {
namespace {

TEST(Surface, LiesAtTheBarycentricCoordinates) {
    const Surface s = surface(triangle_scene());
    expect_near(s.position, {0.25f, 0.5f, 0});
    expect_near(s.ng, {0, 0, 1});
    expect_near(s.ns, {0, 0, 1});
    EXPECT_TRUE(s.front);
    EXPECT_EQ(s.alpha, 1);
}

TEST(Surface, NormalsFaceTheRay) {
    Scene scene = triangle_scene();
    scene.materials[0].double_sided = true;
    scene.meshes[0].normals = {3, normalize(Vec3(0.1f, 0, 1))};
    const Surface front = surface(scene), back = surface(scene, from_back);
    EXPECT_TRUE(front.front);
    EXPECT_FALSE(back.front);
    expect_near(back.ng, {0, 0, -1});
    expect_near(front.ns, normalize(Vec3(0.1f, 0, 1)));
    expect_near(back.ns, -normalize(Vec3(0.1f, 0, 1)));
}

TEST(Surface, FollowsTheTransformOfItsInstance) {
    Scene scene = triangle_scene();
    scene.meshes[0].normals = {3, normalize(Vec3(1, 0, 1))};
    Mat4 matrix;
    matrix.setScale(Vec3(2, 1, 1));
    matrix[3][0] = 10;
    scene.instances[0] = make_instance(0, matrix);
    const Surface s = surface(scene);
    expect_near(s.position, {10.5f, 0.5f, 0});
    expect_near(s.ng, {0, 0, 1});
    expect_near(s.ns, normalize(Vec3(0.5f, 0, 1)));  // normals shrink where space grows
}

TEST(Surface, OfAMirroredInstanceHasTheSameFront) {
    Scene scene = triangle_scene();
    scene.meshes[0].normals = {3, Vec3(0, 0, 1)};
    Mat4 matrix;
    matrix.setScale(Vec3(-1, 1, 1));
    scene.instances[0] = make_instance(0, matrix);
    const Surface s = surface(scene);
    EXPECT_TRUE(s.front);
    expect_near(s.ng, {0, 0, 1});
    expect_near(s.ns, {0, 0, 1});
}

TEST(Surface, ErrorBoundContainsTheExactPoint) {
    std::mt19937 generator(1);
    std::uniform_real_distribution<float> uniform(-1, 1);
    for (const float offset : {0.0f, 1e2f, 1e6f}) {
        for (int i = 0; i < 300; ++i) {
            Scene scene = triangle_scene();
            for (Vec3& p : scene.meshes[0].positions) {
                p = Vec3(uniform(generator), uniform(generator), uniform(generator) + offset);
            }
            Mat4 matrix;
            for (int r = 0; r < 4; ++r) {
                for (int c = 0; c < 3; ++c) matrix[r][c] = uniform(generator);
            }
            const bool placed = i % 2 == 1 && std::fabs(matrix.determinant()) > 0.05f;
            if (placed) scene.instances[0] = make_instance(0, matrix);
            const Hit hit = middle_hit();
            const Surface s = surface(scene);
            const auto& p = scene.meshes[0].positions;
            Vec3d exact = Vec3d(p[0]) * 0.25 + Vec3d(p[1]) * static_cast<double>(hit.u) +
                          Vec3d(p[2]) * static_cast<double>(hit.v);
            if (placed) exact = exact * Mat4d(matrix);
            for (int k = 0; k < 3; ++k) {
                ASSERT_LE(std::fabs(exact[k] - static_cast<double>(s.position[k])),
                          static_cast<double>(s.position_error[k]));
                ASSERT_LT(s.position_error[k], 2e-5f * (offset + 3));
            }
        }
    }
}

TEST(Surface, SpawnedRaysStartOnTheirSideOfTheTriangle) {
    std::mt19937 generator(2);
    std::uniform_real_distribution<float> uniform(-1, 1);
    for (const float offset : {0.0f, 1e2f, 1e6f}) {
        for (int i = 0; i < 1000; ++i) {
            Scene scene = triangle_scene();
            auto& p = scene.meshes[0].positions;
            for (Vec3& corner : p) {
                corner = Vec3(uniform(generator) + offset, uniform(generator), uniform(generator));
            }
            const Surface s = surface(scene);
            const Vec3 direction(uniform(generator), uniform(generator), uniform(generator));
            const Ray ray = spawn_ray(s, direction, 5);
            const Vec3d n = cross(Vec3d(p[1]) - Vec3d(p[0]), Vec3d(p[2]) - Vec3d(p[0]));
            if (n.length() < 0.01) continue;
            const double height = dot(Vec3d(ray.origin) - Vec3d(p[0]), n);
            ASSERT_GE(height * dot(Vec3d(direction), n), 0) << offset;
            EXPECT_EQ(ray.tfar, 5);
        }
    }
}

TEST(Surface, MirrorDirectionIsAboveTheSurfaceWhateverTheNormal) {
    std::mt19937 generator(3);
    std::uniform_real_distribution<float> uniform(-1, 1);
    for (int i = 0; i < 2000; ++i) {
        Scene scene = triangle_scene();
        scene.materials[0].double_sided = true;
        scene.meshes[0].normals = {
            3, normalize(Vec3(uniform(generator), uniform(generator), uniform(generator)))};
        const Vec3 view(uniform(generator), uniform(generator), 0.3f * uniform(generator));
        if (std::fabs(view.z) < 1e-4f) continue;
        const Surface s = surface(scene, towards(view));
        ASSERT_GT(dot(s.ng, s.wo), 0);
        ASSERT_GT(dot(s.ns, s.wo), 0);
        ASSERT_NEAR(s.ns.length(), 1, 1e-5f);
        ASSERT_GT(dot(reflect(s.wo, s.ns), s.ng), 0);
    }
}

TEST(Surface, DiffuseLightKeepsTheMappedNormal) {
    Scene scene = triangle_scene();
    const Vec3 n = normalize(Vec3(0.8f, 0, 0.6f));
    scene.meshes[0].normals = {3, n};
    // The mirror direction of this view at n lies below the triangle, so that ns is bent.
    const Surface s = surface(scene, towards({0.8f, 0, -0.3f}));
    ASSERT_GT((s.ns - n).length(), 0.1f);
    expect_near(s.diffuse_normal(), n, 1e-6f);
    const auto lit_from = [&](const Vec3& wi) { return eval_bsdf(s, wi).diffuse.x; };
    EXPECT_EQ(lit_from(normalize(Vec3(-0.8f, 0, 0.55f))), 0);
    EXPECT_GT(lit_from(n), 0.9f / pi);
    // Light that the triangle hides from n meets the triangle.
    const Ray shadow = spawn_shadow_ray(s, normalize(Vec3(0.9f, 0, -0.1f)), 1);
    EXPECT_GT(shadow.origin.z, 0);
}

TEST(Surface, KeepsNormalsThatNeedNoBending) {
    Scene scene = triangle_scene();
    const Vec3 n = normalize(Vec3(0.3f, 0.2f, 1));
    scene.meshes[0].normals = {3, n};
    expect_near(surface(scene, towards({0.1f, 0, -1})).ns, n, 1e-6f);
}

TEST(Surface, NormalTextureBendsTheNormalRightAndUp) {
    Scene scene = triangle_scene();
    scene.materials[0].normal_texture = add_texel(scene, {204, 128, 230});  // (0.6, 0, 0.8)
    expect_near(surface(scene).ns, {0.6f, 0, 0.8f}, 0.01f);
    scene.images[0].bytes = {128, 204, 230};  // green is up, against v
    expect_near(surface(scene).ns, {0, 0.6f, 0.8f}, 0.01f);
    scene.materials[0].normal_scale = 0.5f;
    expect_near(surface(scene).ns, normalize(Vec3(0, 0.3f, 0.8f)), 0.01f);
}

TEST(Surface, NormalTextureFollowsTheMeshsTangents) {
    Scene scene = triangle_scene();
    scene.meshes[0].normals = {3, Vec3(0, 0, 1)};
    scene.meshes[0].tangents = {3, Vec4(0, 1, 0, 1)};
    scene.materials[0].normal_texture = add_texel(scene, {204, 128, 230});
    expect_near(surface(scene).ns, {0, 0.6f, 0.8f}, 0.01f);
    scene.images[0].bytes = {128, 204, 230};  // bitangent = cross(n, t)·w = −x
    expect_near(surface(scene).ns, {-0.6f, 0, 0.8f}, 0.01f);
    scene.meshes[0].tangents = {3, Vec4(0, 1, 0, -1)};
    expect_near(surface(scene).ns, {0.6f, 0, 0.8f}, 0.01f);
}

/// Applies the texture's transform to the coordinates and tangents of the mesh.
void bake_transform(Mesh& mesh, const TextureRef& ref) {
    const Vec2 origin = transform_uv(ref, {0, 0});
    const Vec2 across = transform_uv(ref, {1, 0}) - origin;
    const Vec2 down = transform_uv(ref, {0, 1}) - origin;
    for (Vec2& uv : mesh.texcoords[0]) uv = transform_uv(ref, uv);
    // In triangle_scene u is x and v runs against y: the inverse of the transform turns tangents.
    const float det = across.x * down.y - across.y * down.x;
    for (Vec4& t : mesh.tangents) {
        const Vec3 turned =
            normalize(Vec3(down.y * t.x + down.x * t.y, across.y * t.x + across.x * t.y, 0) / det);
        t = Vec4(turned.x, turned.y, 0, det < 0 ? -t.w : t.w);
    }
}

std::vector<TextureRef> turned_and_mirrored(const TextureRef& ref) {
    std::vector<TextureRef> refs(6, ref);
    refs[0].rotation = pi;
    refs[1].rotation = pi / 2;
    refs[2].rotation = 0.7f;
    refs[3].scale = {-1, 1};
    refs[4].scale = {2, -3};
    refs[5].scale = {3, 1};
    refs[5].rotation = -0.4f;
    for (TextureRef& turned : refs) turned.offset = {0.3f, 0.1f};
    return refs;
}

TEST(Surface, TangentsFollowTheTransformOfTheTexture) {
    for (const bool tangents : {false, true}) {
        Scene scene = triangle_scene();
        scene.meshes[0].normals = {3, Vec3(0, 0, 1)};
        if (tangents) scene.meshes[0].tangents = {3, Vec4(1, 0, 0, 1)};
        Material& m = scene.materials[0];
        m.clearcoat_factor = 1;
        m.anisotropy_strength = 1;
        const TextureRef texel = add_texel(scene, {204, 170, 230});
        for (const TextureRef& turned : turned_and_mirrored(texel)) {
            m.normal_texture = m.clearcoat_normal_texture = m.anisotropy_texture = turned;
            const Surface transformed = surface(scene);
            Scene baked = scene;
            bake_transform(baked.meshes[0], turned);
            Material& b = baked.materials[0];
            b.normal_texture = b.clearcoat_normal_texture = b.anisotropy_texture = texel;
            const Surface expected = surface(baked);
            expect_near(transformed.ns, expected.ns);
            expect_near(transformed.coat_normal, expected.coat_normal);
            expect_near(transformed.tangent, expected.tangent);
        }
    }
}

TEST(Surface, NormalTextureTurnedByHalfATurnShowsTheOppositeNormal) {
    Scene scene = triangle_scene();
    scene.materials[0].normal_texture = add_texel(scene, {191, 128, 238});  // (0.5, 0, 0.87)
    scene.materials[0].normal_texture.rotation = pi;
    expect_near(surface(scene).ns, {-0.5f, 0, 0.87f}, 0.01f);
    scene.meshes[0].tangents = {3, Vec4(1, 0, 0, 1)};
    expect_near(surface(scene).ns, {-0.5f, 0, 0.87f}, 0.01f);
}

TEST(Surface, AFlatTransformLeavesTheTangentsAsTheyAre) {
    Scene scene = triangle_scene();
    scene.materials[0].normal_texture = add_texel(scene, {204, 128, 230});
    for (const Vec2& scale : {Vec2(0, 1), Vec2(1, 0), Vec2(0, 0)}) {
        scene.materials[0].normal_texture.scale = scale;
        expect_near(surface(scene).ns, {0.6f, 0, 0.8f}, 0.01f);
    }
}

TEST(Surface, NormalTextureIsTheSameBumpOnAMirroredInstance) {
    for (const bool tangents : {false, true}) {
        Scene scene = triangle_scene();
        scene.meshes[0].normals = {3, Vec3(0, 0, 1)};
        if (tangents) scene.meshes[0].tangents = {3, Vec4(1, 0, 0, 1)};
        scene.materials[0].normal_texture = add_texel(scene, {204, 170, 230});
        const Vec3 n = surface(scene).ns;
        Mat4 matrix;
        matrix.setScale(Vec3(-1, 1, 1));
        scene.instances[0] = make_instance(0, matrix);
        expect_near(surface(scene).ns, {-n.x, n.y, n.z});
    }
}

TEST(Surface, NormalTextureBumpsAreDentsFromBehind) {
    Scene scene = triangle_scene();
    scene.materials[0].double_sided = true;
    scene.materials[0].normal_texture = add_texel(scene, {204, 128, 230});
    expect_near(surface(scene, from_back).ns, -surface(scene).ns);
}

TEST(Surface, ShadowRaysStartAboveTheSmoothSurfaceWhereItIsConvex) {
    // A triangle with corners on the unit sphere, 0.3 from the axis. The tangent planes lie above
    // its middle, at height cos 0.3, by sin²0.3 along the normals of the corners.
    Scene scene = triangle_scene();
    Mesh& mesh = scene.meshes[0];
    const auto corner = [](float phi) {
        return Vec3(std::sin(0.3f) * std::cos(phi), std::sin(0.3f) * std::sin(phi), std::cos(0.3f));
    };
    mesh.positions = {corner(0), corner(2 * pi / 3), corner(4 * pi / 3)};
    mesh.normals = mesh.positions;
    Hit hit = middle_hit();
    hit.u = hit.v = 1 / 3.0f;
    const auto offset = [&] {
        return Surfaces(scene).at(from_front, hit, 0).shadow_terminator_offset;
    };
    const float sine = std::sin(0.3f);
    expect_near(offset(), {0, 0, std::cos(0.3f) * sine * sine});
    const Ray shadow = spawn_shadow_ray(Surfaces(scene).at(from_front, hit, 0), {1, 0, 0.01f}, 9);
    EXPECT_GT(shadow.origin.z, 1);

    for (Vec3& n : mesh.normals) n = Vec3(-n.x, -n.y, n.z);
    expect_near(offset(), Vec3(0));
    mesh.normals = {3, Vec3(0, 0, 1)};
    expect_near(offset(), Vec3(0), 1e-6f);
}

TEST(Surface, ShadowRaysEndInTheLightWhereverTheyStart) {
    Surface s = surface(triangle_scene());
    s.shadow_terminator_offset = {0.02f, -0.01f, 0.1f};
    const Vec3 light(1, 2, 3);
    const Vec3 towards = light - s.position;
    const float distance = towards.length();
    const Ray ray = spawn_shadow_ray(s, towards / distance, distance);
    EXPECT_NEAR(ray.direction.length(), 1, 1e-6f);
    expect_near(ray.origin, s.position + s.shadow_terminator_offset);
    expect_near(ray.origin + ray.direction * ray.tfar, light);

    const float infinity = std::numeric_limits<float>::infinity();
    const Ray sun = spawn_shadow_ray(s, {0, 0, 1}, infinity);
    EXPECT_EQ(sun.direction, Vec3(0, 0, 1));
    EXPECT_EQ(sun.tfar, infinity);
}

TEST(Surface, RaysFromBesideACornerAtTheOriginDoNotHitItsTriangle) {
    std::mt19937 generator(3);
    std::uniform_real_distribution<float> uniform(-1, 1), small(1e-6f, 1e-5f);
    int hits = 0;
    for (int i = 0; i < 500; ++i) {
        Scene scene = triangle_scene();
        auto& p = scene.meshes[0].positions;
        for (Vec3& corner : p)
            corner = Vec3(uniform(generator), uniform(generator), uniform(generator));
        const int at_origin = i % 3;
        p[static_cast<size_t>(at_origin)] = Vec3(0);
        Hit hit = middle_hit();
        const float x = small(generator), y = small(generator);
        hit.u = at_origin == 1 ? 1 - x - y : x;
        hit.v = at_origin == 2 ? 1 - x - y : y;
        const Surface s = Surfaces(scene).at(from_front, hit, 0);
        const Vec3 direction(uniform(generator), uniform(generator), uniform(generator));
        const Ray ray = spawn_ray(s, direction, 5);
        std::vector<Hit> found(1);
        make_engine(scene, "embree")->closest({&ray, 1}, found, Coherence::incoherent);
        hits += bool(found[0]);
    }
    EXPECT_EQ(hits, 0);
}

TEST(Surface, OfASphereLiesOnIt) {
    Scene scene = triangle_scene();
    scene.shapes.resize(1);
    scene.shapes[0].radius = 2;
    scene.groups = {{{}, {0}}};
    Ray ray;
    ray.origin = {0.3f, 0.4f, 10};
    ray.direction = {0, 0, -1};
    Hit hit;
    hit.t = 10 - std::sqrt(4 - 0.25f);
    hit.primitive = hit.instance = 0;
    hit.geometry = 1;
    const Surface s = Surfaces(scene).at(ray, hit, 0.01f);
    EXPECT_NEAR(s.position.length(), 2, 1e-6f);
    expect_near(s.ns, s.position / 2);
    EXPECT_TRUE(s.front);
    EXPECT_EQ(s.shadow_terminator_offset, Vec3(0));
    ray.origin.z = -10;
    ray.direction.z = 1;
    hit.t = 10 + std::sqrt(4 - 0.25f);
    const Surface inside = Surfaces(scene).at(ray, hit, 0.01f);
    EXPECT_FALSE(inside.front);
    expect_near(inside.ns, inside.position / -2);
}

TEST(Surface, OfADegenerateTriangleHasFiniteNormals) {
    Scene scene = triangle_scene();
    scene.meshes[0].positions = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
    scene.materials[0].normal_texture = add_texel(scene, {204, 128, 230});
    const Surface s = surface(scene);
    EXPECT_TRUE(std::isfinite(s.ns.x) && std::isfinite(s.ns.y) && std::isfinite(s.ns.z));
    EXPECT_GT(dot(s.ns, s.wo), 0);
}

}  // namespace
}  // namespace sightline
