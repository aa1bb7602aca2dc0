// The ground: what it shows of the scene above it, and what it leaves as it is.
#include "core/color.h"
#include "core/srgb.h"
#include "output/display.h"
#include "render/aov.h"
#include "support/pictures.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline {
namespace {

constexpr int picture_size = 32;

Camera from_side() { return look_at({0, 3, 8}, {0, 1, 0}, {0, 1, 0}, pi / 4); }

RenderSettings ground_settings(GroundKind kind, Background background, int samples = 256) {
    RenderSettings settings = small_settings(from_side(), samples, picture_size, picture_size);
    settings.background = background;
    settings.ground.kind = kind;
    return settings;
}

/// A box with this lowest corner and this size.
Mesh box_mesh(const Vec3& corner, const Vec3& extent) {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.positions.push_back(
            corner + Vec3(i & 1 ? extent.x : 0, i & 2 ? extent.y : 0, i & 4 ? extent.z : 0));
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

Scene ball_scene(const Material& material) { return scene_of(ball({0, 1, 0}, 1), material); }

Vec4 pixel(const Film& film, int x, int y) {
    const auto at = static_cast<size_t>(y * film.window.width() + x);
    const Vec3 c = beauty_at(film, x, y);
    return {c.x, c.y, c.z, film.find("A")->values[at]};
}

Environment grey() { return uniform_environment({0.5f, 0.5f, 0.5f}); }

// Of a sphere whose centre has the distance d from a point of the ground below it, the point sees
// the share (r / d)² of the light that would fall on it.
TEST(ShadowGround, HasTheShadowOfABallUnderAnEvenSky) {
    const Scene scene = scene_of(ball({0, 2, 0}, 1), matte({0.2f, 0.2f, 0.2f}));
    RenderSettings settings = ground_settings(GroundKind::shadow, Background::transparent, 4096);
    settings.width = settings.height = 1;
    // Looks at the origin from beside the ball, through a narrow pixel.
    settings.camera = look_at({0, 0.6f, 3}, {0, 0, 0}, {0, 1, 0}, 0.01f);
    const Environment sky = grey();
    const Vec4 seen = pixel(render_scene(scene, settings, &sky).film, 0, 0);
    EXPECT_NEAR(seen.w, 0.25f, 0.01f);
    EXPECT_EQ(seen.x, 0);
    EXPECT_EQ(seen.y, 0);
    EXPECT_EQ(seen.z, 0);
}

TEST(ShadowGround, OverAColourIsThePictureOnThatColour) {
    const Scene scene = ball_scene(matte({0.8f, 0.3f, 0.1f}));
    const Environment sky = grey();
    RenderSettings settings = ground_settings(GroundKind::shadow, Background::transparent, 64);
    settings.ground.mirror = 0.04f;
    const Film over = render_scene(scene, settings, &sky).film;
    settings.background = Background::color;
    settings.background_color = {0.3f, 0.6f, 0.9f};
    const Film there = render_scene(scene, settings, &sky).film;
    int shaded = 0;
    for (int y = 0; y < picture_size; ++y)
        for (int x = 0; x < picture_size; ++x) {
            const Vec4 a = pixel(over, x, y), b = pixel(there, x, y);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(a[c] + (1 - a.w) * settings.background_color[c], b[c], 1e-5f)
                    << x << " " << y;
            shaded += a.w > 0.05f && a.w < 0.95f;
        }
    EXPECT_GT(shaded, 20);
}

TEST(ShadowGround, LeavesTheBackgroundAsItIsWhereNothingStands) {
    const Scene scene = ball_scene(matte({0.5f, 0.5f, 0.5f}));
    const Environment sky = grey();
    RenderSettings settings = ground_settings(GroundKind::shadow, Background::transparent, 16);
    settings.ground.mirror = 0.04f;
    settings.camera = look_at({40, 3, 8}, {40, 1, 0}, {0, 1, 0}, pi / 4);
    const Film far = render_scene(scene, settings, &sky).film;
    int shaded = 0;
    for (int y = 0; y < picture_size; ++y)
        for (int x = 0; x < picture_size; ++x) shaded += pixel(far, x, y).w != 0;
    EXPECT_LT(shaded, picture_size * picture_size / 8);  // by rays at small angles alone
    settings.ground.height = -1000;
    const Film deep = render_scene(scene, settings, &sky).film;
    for (int x = 0; x < picture_size; ++x) EXPECT_EQ(pixel(deep, x, picture_size - 1).w, 0) << x;
}

/// The largest difference of code values between `over` laid over the backdrop and `there`.
int difference_over(const Image& over, const Vec3& backdrop, const Image& there) {
    double most = 0;
    for (size_t i = 0; i < static_cast<size_t>(there.width * there.height); ++i)
        for (size_t c = 0; c < 3; ++c) {
            const double alpha = over.bytes[4 * i + 3] / 255.0;
            const double behind =
                std::round(255 * static_cast<double>(encode_srgb(backdrop[static_cast<int>(c)])));
            const double sum = over.bytes[4 * i + c] * alpha + behind * (1 - alpha);
            most = std::max(most, std::fabs(std::round(sum) - there.bytes[3 * i + c]));
        }
    return static_cast<int>(most);
}

Scene still_life() {
    SceneBuilder builder;
    Material red = matte({0.9f, 0.1f, 0.05f});
    red.specular_factor = 1;
    red.roughness_factor = 0.2f;
    draw(builder, ball({-0.8f, 0.8f, 0}, 0.8f), red);
    draw(builder, ball({1, 0.6f, 0.5f}, 0.6f),
         absorbing_glass({0.9f, 1, 0.9f}, {0.2f, 0.9f, 0.3f}));
    Material unlit = matte({1, 1, 1});
    unlit.unlit = true;
    draw(builder, ball({0.6f, 0.3f, 1.6f}, 0.3f), unlit);
    return builder.finish();
}

TEST(ShadowGround, ADisplayPictureOverABackdropIsThePictureRenderedThere) {
    const Scene scene = still_life();
    const Environment sky = grey();
    for (const char* name : {"white", "#CCE0FF", "#203040", "#FF0000"}) {
        const Vec3 backdrop = parse_color(name);
        RenderSettings settings = ground_settings(GroundKind::shadow, Background::transparent, 64);
        settings.ground.mirror = 0.04f;
        settings.aovs = {shown_layer, through_layer};
        const Film film = render_scene(scene, settings, &sky).film;
        const Image over = display_picture(film, ToneMap::pbr_neutral, 0, true, backdrop);
        settings.background = Background::color;
        settings.background_color = backdrop;
        settings.aovs = {shown_layer};
        const Image there = display_picture(render_scene(scene, settings, &sky).film,
                                            ToneMap::pbr_neutral, 0, false);
        EXPECT_LE(difference_over(over, backdrop, there), 2) << name;
    }
}

TEST(ShadowGround, HasNoColourInAGreyShadowOnWhite) {
    const Scene scene = ball_scene(matte({0.8f, 0.3f, 0.1f}));
    const Environment sky = grey();
    RenderSettings settings = ground_settings(GroundKind::shadow, Background::transparent, 64);
    settings.aovs = {through_layer};
    const Film film = render_scene(scene, settings, &sky).film;
    const Image image = display_picture(film, ToneMap::pbr_neutral, 0, true);
    const Channel *share = film.find("through.share"), *alpha = film.find("A");
    int shaded = 0;
    for (size_t i = 0; i < alpha->values.size(); ++i) {
        if (share->values[i] < 1 || alpha->values[i] < 0.05f) continue;  // the ball, or light
        ++shaded;
        EXPECT_GE(image.bytes[4 * i + 3], 6);
        for (size_t c = 0; c < 3; ++c)
            EXPECT_LE(image.bytes[4 * i + c], 16) << i;  // half a step of alpha
    }
    EXPECT_GT(shaded, 10);
}

Scene unlit_red_box() {
    Material unlit = matte({1, 0, 0});
    unlit.unlit = true;
    return scene_of(box_mesh({-1, 0.5f, -1}, {2, 2, 2}), unlit);
}

TEST(ShadowGround, MirrorsWhatStandsOnIt) {
    const Environment sky = grey();
    const Scene scene = unlit_red_box();
    RenderSettings settings = ground_settings(GroundKind::shadow, Background::transparent, 16);
    settings.ground.mirror = 0.5f;
    const Film film = render_scene(scene, settings, &sky).film;
    const Vec4 before_box = pixel(film, 16, 25);
    EXPECT_GT(before_box.x, 0.45f);
    EXPECT_LT(before_box.y, 0.01f);
    EXPECT_GT(before_box.w, before_box.x - 1e-3f);
    settings.ground.mirror = 0;
    EXPECT_EQ(pixel(render_scene(scene, settings, &sky).film, 16, 25).x, 0);
}

// Few of the rays that a ground mirrors faintly are traced, each counted for several; all of them
// if the picture has no other noise.
TEST(ShadowGround, MirrorsAsMuchByFewRaysAsByAll) {
    const Environment sky = grey();
    const Scene scene = unlit_red_box();
    RenderSettings settings = ground_settings(GroundKind::shadow, Background::transparent, 1024);
    settings.ground.mirror = 0.04f;
    Needs needs = find_needs(scene, settings, true);
    const RenderedScene few = render_scene(scene, settings, &sky, &needs);
    needs.noise = false;
    const RenderedScene all = render_scene(scene, settings, &sky, &needs);
    const float mirrored = pixel(all.film, 16, 25).x;
    EXPECT_GT(mirrored, 0.04f);
    // A survivor brings 0.5, so there are 2 · mirrored of them per sample. Half the deviation of
    // independent ones: they are stratified.
    const float deviation = 0.5f * std::sqrt(2 * mirrored / 1024);
    EXPECT_NEAR(pixel(few.film, 16, 25).x, mirrored, deviation / 2);
    const auto rays = [](const RenderedScene& of) {
        return of.counters.rays[static_cast<size_t>(RayKind::reflection)];
    };
    EXPECT_LT(rays(few), rays(all) / 2);
}

TEST(ShadowGround, MirrorsWithoutNoiseWhereThereIsNone) {
    SceneBuilder builder;
    draw(builder, box_mesh({-1, 0.5f, -1}, {2, 2, 2}), matte({0.8f, 0.8f, 0.8f}));
    builder.add_light(point_light({0, 9, 6}, 2000));
    const Scene scene = builder.finish();
    RenderSettings settings = ground_settings(GroundKind::shadow, Background::transparent, 1);
    settings.ground.mirror = 0.04f;
    const Film film = render_scene(scene, settings).film;
    EXPECT_GT(pixel(film, 16, 25).x, 0);
    settings.seed = 1;
    expect_same_film(render_scene(scene, settings).film, film);
}

TEST(ShadowGround, HasTheUmbraOfAPointLightAndNothingBesideIt) {
    SceneBuilder builder;
    draw(builder, ball({0, 1, 0}, 1), matte({0.5f, 0.5f, 0.5f}));
    builder.add_light(point_light({-3, 4, 0}, 100));
    const Scene scene = builder.finish();
    RenderSettings settings = ground_settings(GroundKind::shadow, Background::transparent, 1);
    settings.width = settings.height = 1;
    const auto alpha_at = [&](float x) {
        settings.camera = look_at({x, 2, 4}, {x, 0, 0}, {0, 1, 0}, 0.01f);
        return pixel(render_scene(scene, settings).film, 0, 0).w;
    };
    EXPECT_EQ(alpha_at(1.6f), 1);
    EXPECT_EQ(alpha_at(6), 0);
}

TEST(ShadowGround, IsDarkestWhereABoxStandsOnIt) {
    const Environment sky = grey();
    const Scene scene = scene_of(box_mesh({-1, 0, -1}, {2, 2, 2}), matte({0.02f, 0.02f, 0.02f}));
    RenderSettings settings = ground_settings(GroundKind::shadow, Background::color, 64);
    settings.background_color = {1, 1, 1};
    settings.height = 256;
    settings.width = 8;
    settings.camera = look_at({0, 2, 6}, {0, 0, 1}, {0, 1, 0}, 0.5f);
    settings.ground.height = -2e-4f;
    const Film film = render_scene(scene, settings, &sky).film;
    // Down the picture: the box, which is dark, then the ground, which becomes brighter.
    int y = 0;
    while (y < 255 && beauty_at(film, 4, y).x < 0.1f) ++y;
    ASSERT_GT(y, 10);
    ASSERT_LT(y, 250);
    EXPECT_LT(beauty_at(film, 4, y + 1).x, 0.75f);
    for (int next = y + 16; next < 256; next += 16)
        EXPECT_GT(beauty_at(film, 4, next).x, beauty_at(film, 4, next - 16).x - 0.05f) << next;
}

TEST(Ground, IsNotThereFromBelow) {
    const Environment sky = grey();
    const Scene scene = ball_scene(matte({0.5f, 0.5f, 0.5f}));
    for (const GroundKind kind : {GroundKind::shadow, GroundKind::matte}) {
        RenderSettings settings = ground_settings(kind, Background::transparent, 4);
        settings.camera = look_at({0, -5, 0.1f}, {0, 1, 0}, {0, 1, 0}, pi / 4);
        const Film film = render_scene(scene, settings, &sky).film;
        EXPECT_EQ(pixel(film, 0, 0).w, 0);
        EXPECT_EQ(pixel(film, 16, 16).w, 1);  // the ball
    }
}

TEST(MatteGround, SendsItsShareOfTheLight) {
    const Environment sky = grey();
    const Scene scene = scene_of(ball({0, 500, 0}, 1), matte({0.5f, 0.5f, 0.5f}));
    RenderSettings settings = ground_settings(GroundKind::matte, Background::transparent, 64);
    settings.ground.color = {0.8f, 0.4f, 0.2f};
    const Vec4 seen = pixel(render_scene(scene, settings, &sky).film, 16, 30);
    EXPECT_NEAR(seen.x, 0.4f, 0.004f);
    EXPECT_NEAR(seen.y, 0.2f, 0.002f);
    EXPECT_NEAR(seen.z, 0.1f, 0.001f);
    EXPECT_EQ(seen.w, 1);
    EXPECT_EQ(pixel(render_scene(scene, settings, &sky).film, 16, 1).w, 0);  // above the horizon
}

TEST(MatteGround, LightsWhatStandsOnItFromBelow) {
    const Environment sky = grey();
    const Scene scene =
        scene_of(quad_mesh({-0.1f, 3, -0.1f}, {0.2f, 0, 0}, {0, 0, 0.2f}), matte({1, 1, 1}));
    RenderSettings settings = ground_settings(GroundKind::matte, Background::transparent, 1024);
    settings.ground.color = {1, 0, 0};
    settings.width = settings.height = 1;
    settings.camera = look_at({0, 1, 0}, {0, 3, 0}, {0, 0, 1}, 0.05f);
    const Vec4 seen = pixel(render_scene(scene, settings, &sky).film, 0, 0);
    EXPECT_NEAR(seen.x, 0.5f, 0.02f);
    EXPECT_NEAR(seen.y, 0, 0.02f);
}

TEST(MatteGround, HoldsOffLampsBelowIt) {
    SceneBuilder builder;
    draw(builder, ball({0, 1, 0}, 1), matte({1, 1, 1}));
    builder.add_light(point_light({0, -4, 2}, 1000));
    const Scene scene = builder.finish();
    RenderSettings settings = ground_settings(GroundKind::matte, Background::color, 1);
    EXPECT_EQ(pixel(render_scene(scene, settings).film, 16, 18).x, 0);
    settings.ground.kind = GroundKind::nothing;
    EXPECT_GT(pixel(render_scene(scene, settings).film, 16, 18).x, 0);
}

/// A square of this side a unit above the origin that shines down, and what may be in its way.
Scene lamp_scene(float side, float radiance, bool is_covered = false) {
    SceneBuilder builder;
    Material lamp = matte({0, 0, 0});
    lamp.emissive_factor = Vec3(radiance);
    draw(builder, quad_mesh({-side / 2, 1, -side / 2}, {side, 0, 0}, {0, 0, side}), lamp);
    const Material cover = matte({0, 0, 0});
    if (is_covered)
        draw(builder, quad_mesh({-side, 0.9f, -side}, {2 * side, 0, 0}, {0, 0, 2 * side}), cover);
    return builder.finish();
}

/// What is seen of a point of the ground, past the lamp.
Vec3 seen_at(const Scene& scene, RenderSettings settings, float x) {
    settings.width = settings.height = 1;
    settings.camera = look_at({x, 0.5f, 3}, {x, 0, 0}, {0, 1, 0}, 0.001f);
    settings.aovs = {"lights"};
    const Film film = render_scene(scene, settings).film;
    const Vec3 seen = beauty_at(film, 0, 0);
    EXPECT_NEAR(
        film.find("light.emission.R")->values[0] + film.find("light.environment.R")->values[0],
        seen.x, 1e-6f);
    return seen;
}

// A small square of radiance L and area A has the irradiance L A cos⁴ / h² below it.
TEST(MatteGround, IsLitByEmissiveSurfaces) {
    RenderSettings settings = ground_settings(GroundKind::matte, Background::color, 256);
    settings.ground.color = {0.8f, 0.4f, 0.2f};
    const Vec3 below = seen_at(lamp_scene(0.02f, 1000), settings, 0);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(below[c], settings.ground.color[c] * 0.4f / pi, 2e-3f * below[c]) << c;
    const Vec3 beside = seen_at(lamp_scene(0.02f, 1000), settings, 1);
    EXPECT_NEAR(beside.x, below.x / 4, 2e-3f * beside.x);
    EXPECT_EQ(seen_at(lamp_scene(0.02f, 1000, true), settings, 0), Vec3(0));
}

TEST(CycloramaGround, IsLitByEmissiveSurfacesNearTheScene) {
    RenderSettings settings = ground_settings(GroundKind::cyclorama, Background::color, 256);
    settings.background_color = settings.ground.color = {0.5f, 0.5f, 0.5f};
    // The radius of the scene is a side over the root of 2, and that of its surroundings 5 times.
    const auto gained = [&](float x) {
        return seen_at(lamp_scene(1, 10), settings, x).x - seen_at(lamp_scene(1, 0), settings, x).x;
    };
    EXPECT_GT(gained(0.6f), 0.1f);
    EXPECT_GT(gained(2), 1e-3f);
    EXPECT_EQ(gained(3.6f), 0);
}

TEST(CycloramaGround, BecomesTheBackgroundWithoutAHorizon) {
    const Environment sky = uniform_environment({0.9f, 0.9f, 0.9f});
    const Scene scene = scene_of(ball({0, 500, 0}, 1), matte({0.5f, 0.5f, 0.5f}));
    RenderSettings settings = ground_settings(GroundKind::cyclorama, Background::color, 64);
    settings.background_color = settings.ground.color = {0.5f, 0.6f, 0.7f};
    settings.height = 200;
    settings.width = 8;
    settings.camera = look_at({4, 2, 12}, {4, 1.5f, 0}, {0, 1, 0}, pi / 4);  // beside the ball
    const Film film = render_scene(scene, settings, &sky).film;
    EXPECT_NEAR(pixel(film, 4, 0).x, 0.5f, 1e-5f);
    float darkest = 1;
    for (int y = 1; y < 200; ++y) {
        EXPECT_NEAR(pixel(film, 4, y).x, pixel(film, 4, y - 1).x, 0.006f) << y;
        darkest = std::min(darkest, pixel(film, 4, y).x);
    }
    EXPECT_LT(darkest, 0.48f);  // near the scene; 0.9 of the background where it stands
}

TEST(Ground, IsSeenByAnOrthographicCameraThatStandsBelowIt) {
    const Environment sky = grey();
    const Scene scene = ball_scene(matte({0.5f, 0.5f, 0.5f}));
    RenderSettings settings = ground_settings(GroundKind::matte, Background::transparent, 4);
    settings.ground.color = {1, 1, 1};
    settings.camera = look_at({0, 1, 3}, {0, 0.5f, 0}, {0, 1, 0}, pi / 4);
    settings.camera.orthographic = true;
    settings.camera.xmag = settings.camera.ymag = 4;
    EXPECT_EQ(pixel(render_scene(scene, settings, &sky).film, 16, 31).w, 1);
}

TEST(Ground, ChangesNothingOfALayerButBeauty) {
    const Environment sky = grey();
    const Scene scene = ball_scene(matte({0.5f, 0.5f, 0.5f}));
    RenderSettings settings = ground_settings(GroundKind::nothing, Background::color, 4);
    settings.aovs = {"depth", "normal", "object", "material", "position"};
    const Film without = render_scene(scene, settings, &sky).film;
    settings.ground.kind = GroundKind::matte;
    const Film with = render_scene(scene, settings, &sky).film;
    for (size_t i = 4; i < with.channels.size(); ++i)
        EXPECT_TRUE(same_bits(with.channels[i], without.channels[i])) << with.channels[i].name;
}

TEST(Ground, IsTheSameForAnyNumberOfThreads) {
    const Environment sky = grey();
    const Scene scene = still_life();
    RenderSettings settings = ground_settings(GroundKind::shadow, Background::transparent, 16);
    settings.ground.mirror = 0.04f;
    RenderRun one, two;
    one.threads = 1;
    two.threads = 2;
    expect_same_film(render_scene(scene, settings, &sky, nullptr, one).film,
                     render_scene(scene, settings, &sky, nullptr, two).film);
}

}  // namespace
}  // namespace sightline
