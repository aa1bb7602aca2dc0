#include "render/texture_levels.h"

#include "image/halving.h"
#include "support/pictures.h"

#include <cmath>
#include <random>
#include <utility>

namespace sightline {
namespace {

constexpr std::array<int, 2> size{1024, 1024};

/// A square of two units, of one image of 1024 × 1024 texels: 512 texels a unit.
Scene card(const Material& material, const Vec3& corner = {-1, -1, 0}) {
    Material m = material;
    m.base_color_texture.texture = 0;
    Scene scene = scene_of(quad_mesh(corner, {2, 0, 0}, {0, 2, 0}), m);
    Texture texture;
    texture.image = 0;
    scene.textures.push_back(texture);
    scene.images.emplace_back();
    return scene;
}

int level_of(const Scene& scene, const RenderSettings& settings) {
    return TextureLevels(scene, {{size}}).wanted(scene, settings).at(0).level;
}

/// `width` units across the picture of 64 × 64 pixels.
RenderSettings flat_view(float width, int samples = 1) {
    Camera camera = look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 1);
    camera.orthographic = true;
    camera.xmag = camera.ymag = width / 2;
    return small_settings(camera, samples, 64, 64);
}

TEST(TextureLevels, FollowFromTheTexelsOfAPixel) {
    const Scene scene = card(matte({1, 1, 1}));
    // 2 units of 1024 texels over 64 pixels: 16 texels a pixel, a little less is certain.
    EXPECT_EQ(level_of(scene, flat_view(2.1f)), 4);
    EXPECT_EQ(level_of(scene, flat_view(1.9f)), 3);
    EXPECT_EQ(level_of(scene, flat_view(4.2f)), 5);
    EXPECT_EQ(level_of(scene, flat_view(0.1f)), 0);
    // 16 samples have a quarter of the width each.
    EXPECT_EQ(level_of(scene, flat_view(2.1f, 16)), 2);
    RenderSettings until_converged = flat_view(2.1f);
    until_converged.error = 0.1f;
    until_converged.max_samples = 200;
    EXPECT_EQ(level_of(scene, until_converged), 0);
    RenderSettings whole = flat_view(2.1f);
    whole.full_textures = true;
    EXPECT_EQ(level_of(scene, whole), 0);
}

TEST(TextureLevels, GrowWithTheDistanceOfTheNearestPoint) {
    const Scene scene = card(matte({1, 1, 1}));
    const auto from = [&](float z, float aperture = 0) {
        RenderSettings settings =
            small_settings(look_at({0, 0, z}, {0, 0, 0}, {0, 1, 0}, 1), 1, 64, 64);
        settings.aperture = aperture;
        return level_of(scene, settings);
    };
    const int near = from(10), far = from(40);
    EXPECT_EQ(far, near + 2);
    EXPECT_EQ(from(0.001f), 0);
    EXPECT_LT(from(10, 10), near);  // the lens comes nearer
}

TEST(TextureLevels, OfMeshesWithoutAreaOrWithHugeCoordinatesAreInRange) {
    Scene flat = card(matte({1, 1, 1}));
    for (Vec3& p : flat.meshes[0].positions) p.y = 0;
    EXPECT_EQ(level_of(flat, flat_view(2.1f)), 16);
    const RenderSettings at_the_mesh =
        small_settings(look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 1), 1, 64, 64);
    EXPECT_EQ(level_of(flat, at_the_mesh), 16);  // no ray hits it
    EXPECT_EQ(level_of(card(matte({1, 1, 1})), at_the_mesh), 0);
    Scene huge = card(matte({1, 1, 1}));
    for (Vec2& uv : huge.meshes[0].texcoords[0]) uv *= 3e38f;
    EXPECT_EQ(level_of(huge, flat_view(2.1f)), 0);
}

TEST(TextureLevels, OfViewsFromOneDistanceAreTheSame) {
    const Scene scene = card(matte({1, 1, 1}));
    const auto from = [&](const Vec3& direction) {
        return level_of(
            scene,
            small_settings(look_at(normalize(direction) * 7, {0, 0, 0}, {0, 1, 0}, 1), 1, 64, 64));
    };
    EXPECT_EQ(from({0, 0, 1}), from({1, 0, 0.1f}));
    EXPECT_EQ(from({0, 0, 1}), from({1, 1, 1}));
}

TEST(TextureLevels, AnInstanceThatIsEnlargedNeedsFinerOnes) {
    for (const float scale : {1.0f, 4.0f}) {
        Material m = matte({1, 1, 1});
        m.base_color_texture.texture = 0;
        SceneBuilder builder;
        const uint32_t material = builder.add_material(m);
        const uint32_t mesh =
            builder.add_mesh(quad_mesh({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), material);
        builder.add_instance(mesh, Mat4().setScale(scale));
        Scene scene = builder.finish();
        Texture texture;
        texture.image = 0;
        scene.textures.push_back(texture);
        scene.images.emplace_back();
        EXPECT_EQ(level_of(scene, flat_view(4.2f)), scale == 1 ? 5 : 3);
    }
}

TEST(TextureLevels, AreWholeWhereALookupHasNoFootprint) {
    Material m = matte({1, 1, 1});
    EXPECT_GT(level_of(card(m), flat_view(2.1f)), 0);
    for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend}) {
        m.alpha_mode = mode;
        EXPECT_EQ(level_of(card(m), flat_view(2.1f)), 0);
    }
    m = matte({1, 1, 1});
    m.transmission_factor = 0.5f;
    EXPECT_EQ(level_of(card(m), flat_view(2.1f)), 0);
    m = matte({1, 1, 1});
    m.emissive_factor = Vec3(1);
    EXPECT_GT(level_of(card(m), flat_view(2.1f)), 0);  // the base colour
    m.emissive_texture.texture = 0;
    EXPECT_EQ(level_of(card(m), flat_view(2.1f)), 1);  // 512 texels: as emitters are sampled
    m.clearcoat_factor = 0.5f;
    EXPECT_EQ(level_of(card(m), flat_view(2.1f)), 0);
}

/// Adds a triangle with legs of this length that shows one texel.
void add_sliver(Scene& scene, float leg, const Vec3& corner) {
    Mesh& mesh = scene.meshes[0];
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (const Vec3& p : {Vec3(0, 0, 0), Vec3(leg, 0, 0), Vec3(0, leg, 0)}) {
        mesh.positions.push_back(corner + p);
        mesh.texcoords[0].push_back({0.3f, 0.3f});
        if (!mesh.normals.empty()) mesh.normals.push_back({0, 0, 1});
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
}

TEST(TextureLevels, AreNotThoseOfTrianglesThatCoverNextToNothing) {
    const float pixel = 2.1f / 64;
    const float most = std::sqrt(2 * float(TextureLevels::ignored_share)) * 64 * pixel;
    for (const float leg : {0.9f * most, 1.1f * most}) {
        Scene scene = card(matte({1, 1, 1}));
        add_sliver(scene, leg, {-1, -1, 0});
        EXPECT_EQ(level_of(scene, flat_view(2.1f)), leg < most ? 4 : 0);
        EXPECT_EQ(level_of(scene, flat_view(2.1f, 16)), leg < most ? 2 : 0);
    }
    Scene several = card(matte({1, 1, 1}));
    for (const float x : {-1.0f, 0.0f}) add_sliver(several, 0.8f * most, {x, -1, 0});
    EXPECT_EQ(level_of(several, flat_view(2.1f)), 0);  // together more
}

TEST(TextureLevels, AreThoseOfWhatCameraRaysSeeIfThatSavesMuch) {
    const auto seen_level = [](Scene& scene, const RenderSettings& settings, int side) {
        const auto intersector = make_embree(scene, find_needs(scene, settings, false).embree);
        const std::array<int, 2> sides{side, side};
        return TextureLevels(scene, {{sides}})
            .wanted(scene, settings, intersector.get())
            .at(0)
            .level;
    };
    constexpr int side = 8192;  // 128 texels a pixel
    Scene scene = card(matte({1, 1, 1}));
    EXPECT_EQ(seen_level(scene, flat_view(2.1f), side), 7);
    add_sliver(scene, 1, {-0.5f, -0.5f, -1});  // behind the card
    EXPECT_EQ(seen_level(scene, flat_view(2.1f), side), TextureLevels::hidden_levels);
    EXPECT_EQ(seen_level(scene, flat_view(2.1f), 1024), 0);  // too small for rays
    RenderSettings from_behind = flat_view(2.1f);
    from_behind.camera = look_at({0, 0, -5}, {0, 0, 0}, {0, 1, 0}, 1);
    from_behind.camera.orthographic = true;
    from_behind.camera.xmag = from_behind.camera.ymag = 1.05f;
    EXPECT_EQ(seen_level(scene, from_behind, side), 0);
    // Backs that are not drawn are not seen, but seen through.
    scene.materials[scene.meshes[0].material].double_sided = false;
    EXPECT_EQ(seen_level(scene, flat_view(2.1f), side), TextureLevels::hidden_levels);
    EXPECT_EQ(seen_level(scene, from_behind, side), TextureLevels::hidden_levels);
    for (size_t i = 0; i < 2; ++i)
        std::swap(scene.meshes[0].triangles[i][1], scene.meshes[0].triangles[i][2]);
    EXPECT_EQ(seen_level(scene, flat_view(2.1f), side), 0);
}

TEST(TextureLevels, AreWholeWithoutMipmapsAndForTwoEncodings) {
    Scene scene = card(matte({1, 1, 1}));
    scene.textures[0].min = Filter::linear;
    EXPECT_EQ(level_of(scene, flat_view(2.1f)), 0);
    Material m = matte({1, 1, 1});
    m.normal_texture.texture = 0;
    EXPECT_EQ(level_of(card(m), flat_view(2.1f)), 0);
}

TEST(TextureLevels, OneTexelForAWholeTriangleNeedsTheImageWhole) {
    Scene scene = card(matte({1, 1, 1}));
    for (Vec2& uv : scene.meshes[0].texcoords[0]) uv = {0.3f, 0.3f};
    EXPECT_EQ(level_of(scene, flat_view(2.1f)), 0);
}

/// Noise of the given side, or the level of it that the settings want plus `more`.
void set_noise(Scene& scene, const RenderSettings& settings, int side, int more) {
    std::mt19937 generator(5);
    Image noise;
    noise.width = noise.height = side;
    noise.channels = 3;
    for (int i = 0; i < side * side * 3; ++i) noise.bytes.push_back(uint8_t(generator() >> 24));
    const std::array<int, 2> sides{side, side};
    WantedLevel wanted = TextureLevels(scene, {{sides}}).wanted(scene, settings).at(0);
    wanted.level += more;
    keep_level(noise, wanted);
    scene.images.assign(1, noise);
}

/// A room of textured mirrors around a textured ball of glass, which magnifies.
Scene room(bool with_lens) {
    Material mirror = matte({1, 1, 1});
    mirror.metallic_factor = 1;
    mirror.roughness_factor = 0;
    mirror.base_color_texture.texture = 0;
    SceneBuilder builder;
    const uint32_t walls = builder.add_material(mirror);
    for (const Vec3& side : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
        for (const float sign : {-1.0f, 1.0f}) {
            const Vec3 u(side.y, side.z, side.x), v(side.z, side.x, side.y);
            builder.add_instance(
                builder.add_mesh(quad_mesh(side * (4 * sign) - (u + v) * 4, u * 8, v * 8), walls));
        }
    }
    if (with_lens) {
        Material glass = matte({1, 1, 1});
        glass.transmission_factor = 1;
        glass.roughness_factor = 0;
        glass.thickness_factor = 1;
        draw(builder, ball({0, 0, 0}, 1), glass);
    }
    Scene scene = builder.finish();
    Texture texture;
    texture.image = 0;
    scene.textures.push_back(texture);
    scene.images.emplace_back();
    for (Material& material : scene.materials) material.double_sided = true;
    return scene;
}

/// The share of rays whose lookups wanted a finer level than there is.
double finer_share(const Scene& scene, const RenderSettings& settings) {
    const Needs needs = find_needs(scene, settings, false);
    const auto intersector = make_embree(scene, needs.embree);
    const RenderContext context(scene, settings, needs, *intersector, nullptr);
    const Counters counters = render(context, [](const Film&) {}).counters;
    const auto rays = [&](RayKind kind) { return counters.rays[static_cast<size_t>(kind)]; };
    return double(context.surfaces.finer_lookups()) /
           double(rays(RayKind::camera) + rays(RayKind::reflection) + rays(RayKind::refraction));
}

TEST(TextureLevels, NoRayReadsAFinerOneInARoomOfMirrorsWithAMagnifyingGlass) {
    for (const bool with_lens : {false, true}) {
        for (const int samples : {1, 4}) {
            Scene scene = room(with_lens);
            const Camera camera = look_at({0.5f, 0.2f, 3}, {0, 0, 0}, {0, 1, 0}, 1);
            const RenderSettings settings = small_settings(camera, samples, 48, 48);
            set_noise(scene, settings, 2048, 0);
            ASSERT_GT(scene.images[0].level, 0);
            EXPECT_EQ(finer_share(scene, settings), 0);
            // The bound is not idle: the nearest wall, behind the camera, is three levels nearer
            // than those that are seen.
            set_noise(scene, settings, 2048, 4);
            EXPECT_GT(finer_share(scene, settings), 0.01);
        }
    }
}

// A narrow view, whose rays want levels that are coarser than the wall behind the camera may need.
TEST(TextureLevels, OfWhatCameraRaysSeeAreNotFinerThanThoseOfMirroredAndRefractedOnes) {
    for (const bool with_lens : {false, true}) {
        for (const int samples : {1, 4}) {
            Scene scene = room(with_lens);
            const Camera camera = look_at({0.5f, 0.2f, 3}, {0, 0, 0}, {0, 1, 0}, 0.15f);
            const RenderSettings settings = small_settings(camera, samples, 48, 48);
            const auto intersector = make_embree(scene, find_needs(scene, settings, false).embree);
            set_noise(scene, settings, 2048, 0);
            const int bound = scene.images[0].level;
            const int seen = TextureLevels(scene, {{{2048, 2048}}})
                                 .wanted(scene, settings, intersector.get())
                                 .at(0)
                                 .level;
            ASSERT_GT(seen, bound);
            set_noise(scene, settings, 2048, seen - bound);
            EXPECT_LE(finer_share(scene, settings), TextureLevels::ignored_share);
            set_noise(scene, settings, 2048, seen - bound + 2);
            EXPECT_GT(finer_share(scene, settings), 0.01);
        }
    }
}

TEST(TextureLevels, ThatNoRayReadsMakeNoDifference) {
    Scene scene = room(true);
    const Camera camera = look_at({0.5f, 0.2f, 3}, {0, 0, 0}, {0, 1, 0}, 1);
    RenderSettings settings = small_settings(camera, 1, 48, 48);
    set_noise(scene, settings, 2048, 0);
    const RenderedScene reduced = render_scene(scene, settings);
    settings.full_textures = true;
    set_noise(scene, settings, 2048, 0);
    ASSERT_EQ(scene.images[0].level, 0);
    EXPECT_EQ(render_scene(scene, settings).film.find("R")->values, reduced.film.find("R")->values);
}

// The emitter's image is decoded at a quarter, from which its samples read means.
TEST(TextureLevels, OfEmittersMakeNoDifferenceToTheirLight) {
    Material lamp = matte({0, 0, 0});
    lamp.emissive_factor = {20, 20, 20};
    lamp.emissive_texture.texture = 0;
    SceneBuilder builder;
    draw(builder, quad_mesh({-4, -1, 4}, {8, 0, 0}, {0, 0, -8}), matte({0.8f, 0.8f, 0.8f}));
    draw(builder, quad_mesh({-1, 1, -1}, {2, 0, 0}, {0, 2, 0}), lamp);
    Scene scene = builder.finish();
    Texture texture;
    texture.image = 0;
    scene.textures.push_back(texture);
    scene.images.emplace_back();
    RenderSettings settings =
        small_settings(look_at({0, 1.5f, 8}, {0, 0, 0}, {0, 1, 0}, pi / 4), 1, 48, 48);
    set_noise(scene, settings, 2048, 0);
    ASSERT_EQ(scene.images[0].level, 2);
    const RenderedScene reduced = render_scene(scene, settings);
    settings.full_textures = true;
    set_noise(scene, settings, 2048, 0);
    ASSERT_EQ(scene.images[0].level, 0);
    expect_same_film(render_scene(scene, settings).film, reduced.film);
    EXPECT_GT(reduced.counters.area_light_samples, 0u);
}

}  // namespace
}  // namespace sightline
