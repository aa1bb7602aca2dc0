#include "intersect/engines.h"
#include "support/pictures.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace sightline {
namespace {

// E = I cos θ / d² (KHR_lights_punctual), L = ρ E / π for a Lambertian plane.
TEST(Render, APointLightOverAMattePlaneFollowsTheCosineAndInverseSquareLaws) {
    SceneBuilder builder;
    draw(builder, quad_mesh({-10, 0, 10}, {20, 0, 0}, {0, 0, -20}), matte({0.5f, 0.25f, 1}));
    builder.add_light(point_light({1, 2, 0}, 7));
    const Scene scene = builder.finish();
    const RenderSettings settings =
        small_settings(look_at({0, 5, 0}, {0, 0, 0}, {0, 0, -1}, pi / 4), 1, 65, 65);
    const auto result = render_scene(scene, settings);
    const float d2 = 1 + 4, cosine = 2 / std::sqrt(d2);
    const float expected = 7 * cosine / d2 / pi;
    const Vec3 got = beauty_at(result.film, 32, 32);
    EXPECT_NEAR(got.x, 0.5f * expected, 1e-5f);
    EXPECT_NEAR(got.y, 0.25f * expected, 1e-5f);
    EXPECT_NEAR(got.z, expected, 1e-5f);
}

TEST(Render, AnObjectBetweenPlaneAndLightCastsAShadow) {
    SceneBuilder builder;
    const Material white = matte({1, 1, 1});
    draw(builder, quad_mesh({-10, 0, 10}, {20, 0, 0}, {0, 0, -20}), white);
    draw(builder, quad_mesh({-1, 1, 0.5f}, {2, 0, 0}, {0, 0, -1}), white);
    builder.add_light(point_light({0, 2, 0}, 7));
    Scene scene = builder.finish();
    const RenderSettings settings =
        small_settings(look_at({0, 0.5f, 3}, {0, 0, 0}, {0, 1, 0}, pi / 4), 1, 65, 65);
    EXPECT_EQ(beauty_at(render_scene(scene, settings).film, 32, 32), Vec3(0, 0, 0));
    scene.lights[0].position = {0, 0.9f, 0};  // below the card
    EXPECT_GT(beauty_at(render_scene(scene, settings).film, 32, 32).x, 0.1f);
}

TEST(Render, AWhiteMatteBallIsInvisibleInAUniformEnvironment) {
    const Scene scene = scene_of(ball({0, 0, 0}, 1), matte({1, 1, 1}));
    const Environment white = uniform_environment({1, 1, 1});
    RenderSettings settings = small_settings(fit_camera(scene.bounds), 256, 32, 32);
    settings.background = Background::environment;
    const auto result = render_scene(scene, settings, &white);
    double sum = 0;
    for (const float v : result.film.find("G")->values) sum += static_cast<double>(v);
    EXPECT_NEAR(sum / (32 * 32), 1, 0.01);
    EXPECT_NEAR(beauty_at(result.film, 16, 16).y, 1, 0.05f);
}

// Two estimators of one integral: rays of the lobe alone, and rays and sampled light by MIS.
TEST(Render, SamplingTheEnvironmentDoesNotChangeTheBrightnessOfRoughMetal) {
    Material metal;
    metal.roughness_factor = 1;
    metal.double_sided = true;
    const Scene scene = scene_of(quad_mesh({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), metal);
    const Environment white = uniform_environment({1, 1, 1});
    const RenderSettings settings =
        small_settings(look_at({0, 1.5f, 1}, {0, 0, 0}, {0, 1, 0}, 0.02f), 1024, 17, 17);
    Needs needs = find_needs(scene, settings, true);
    const float both = beauty_at(render_scene(scene, settings, &white, &needs).film, 8, 8).y;
    needs.environment_light = false;
    const float lobe_alone = beauty_at(render_scene(scene, settings, &white, &needs).film, 8, 8).y;
    EXPECT_NEAR(both, lobe_alone, 0.01f);
    EXPECT_NEAR(lobe_alone, 1, 0.01f);  // several scatterings between microfacets lose nothing
}

TEST(Render, AMirrorTintsTheEnvironment) {
    Material mirror;
    mirror.base_color_factor = {0.9f, 0.5f, 0.1f, 1};
    mirror.roughness_factor = 0;
    const Scene scene = scene_of(quad_mesh({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), mirror);
    const Environment grey = uniform_environment({0.5f, 0.5f, 0.5f});
    const RenderSettings settings =
        small_settings(look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, pi / 4), 1, 33, 33);
    const Vec3 got = beauty_at(render_scene(scene, settings, &grey).film, 16, 16);
    EXPECT_NEAR(got.x, 0.45f, 1e-3f);
    EXPECT_NEAR(got.y, 0.25f, 1e-3f);
    EXPECT_NEAR(got.z, 0.05f, 1e-3f);
}

// An absorbing slab of thickness 2 seen head on: Fresnel twice and Beer–Lambert once.
TEST(Render, AThickSlabOfGlassAbsorbsByBeersLaw) {
    const Material glass = absorbing_glass({1, 1, 1}, {0.5f, 0.5f, 0.5f});
    SceneBuilder builder;
    const uint32_t m = builder.add_material(glass);
    for (const Mesh& side : {quad_mesh({-50, -50, 1}, {100, 0, 0}, {0, 100, 0}),
                             quad_mesh({-50, -50, -1}, {0, 100, 0}, {100, 0, 0})})
        builder.add_instance(builder.add_mesh(side, m));
    const Scene scene = builder.finish();
    RenderSettings settings =
        small_settings(look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 0.01f), 1, 33, 33);
    settings.depth = 2;  // straight through, no inner reflections
    settings.background_color = {1, 1, 1};
    const float reflected = 0.04f, through = 0.96f * 0.96f * 0.25f;
    // The reflection at the first surface shows the background, too.
    EXPECT_NEAR(beauty_at(render_scene(scene, settings).film, 16, 16).y, through + reflected,
                1e-3f);
}

TEST(Render, BlendedSurfacesMixWithTheBackground) {
    Material film = matte({1, 1, 1});
    film.unlit = true;
    film.base_color_factor = {1, 0, 0, 0.25f};
    film.alpha_mode = AlphaMode::blend;
    const Scene scene = scene_of(quad_mesh({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), film);
    RenderSettings settings =
        small_settings(look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, pi / 4), 1, 33, 33);
    settings.background_color = {0, 0, 1};
    EXPECT_EQ(beauty_at(render_scene(scene, settings).film, 16, 16), Vec3(0.25f, 0, 0.75f));
    settings.background = Background::transparent;
    const auto result = render_scene(scene, settings);
    EXPECT_NEAR(result.film.find("A")->values[16 * 33 + 16], 0.25f, 1e-6f);
    EXPECT_EQ(result.film.find("A")->values[0], 0);
}

TEST(Render, BlendedSurfacesCastPartialShadows) {
    const auto floor_radiance = [](bool covered) {
        Material film = matte({1, 1, 1});
        film.base_color_factor.w = 0.25f;
        film.alpha_mode = AlphaMode::blend;
        SceneBuilder builder;
        draw(builder, quad_mesh({-10, 0, 10}, {20, 0, 0}, {0, 0, -20}), matte({1, 1, 1}));
        if (covered) draw(builder, quad_mesh({-1, 1, 0.5f}, {2, 0, 0}, {0, 0, -1}), film);
        builder.add_light(point_light({0, 2, 0}, 10));
        const RenderSettings settings =
            small_settings(look_at({0, 0.5f, 3}, {0, 0, 0}, {0, 1, 0}, pi / 4), 1, 65, 65);
        return beauty_at(render_scene(builder.finish(), settings).film, 32, 32).x;
    };
    const float lit = floor_radiance(false), shaded = floor_radiance(true);
    EXPECT_GT(shaded, 0.5f * lit);
    EXPECT_LT(shaded, 0.9f * lit);
}

TEST(Render, AnAreaLightGivesTheIrradianceOfItsFormFactor) {
    SceneBuilder builder;
    draw(builder, quad_mesh({-5, 0, 5}, {10, 0, 0}, {0, 0, -10}), matte({1, 1, 1}));
    Material lamp = matte({0, 0, 0});
    lamp.emissive_factor = {1, 1, 1};
    lamp.double_sided = false;
    draw(builder, quad_mesh({-1, 1, -1}, {2, 0, 0}, {0, 0, 2}), lamp);
    const Scene scene = builder.finish();
    const RenderSettings settings =
        small_settings(look_at({0, 0.5f, 3}, {0, 0, 0}, {0, 1, 0}, 0.02f), 1024, 17, 17);
    // A 2×2 square 1 above: four quarter squares, F = (2/π)(a/√(1+a²)) atan(a/√(1+a²)), a = 1.
    const float a = 1 / std::sqrt(2.0f);
    const float form_factor = 4 * (1 / (2 * pi)) * 2 * a * std::atan(a);
    EXPECT_NEAR(beauty_at(render_scene(scene, settings).film, 8, 8).x, form_factor, 0.01f);
}

TEST(Render, ThePictureIsBitIdenticalForAnyNumberOfThreads) {
    const Scene scene = rich_scene();
    const Environment sky = uniform_environment({0.3f, 0.4f, 0.6f});
    RenderSettings settings = rich_settings(4);
    for (const float error : {0.0f, 0.05f}) {
        settings.error = error;
        const auto one = render_scene(scene, settings, &sky, nullptr, {.threads = 1});
        const auto three = render_scene(scene, settings, &sky, nullptr, {.threads = 3});
        expect_same_film(one.film, three.film);
    }
}

void expect_equal_crop(RenderSettings settings) {
    const Scene scene = rich_scene();
    const Environment sky = uniform_environment({0.3f, 0.4f, 0.6f});
    const auto whole = render_scene(scene, settings, &sky);
    settings.crop = {13, 7, 50, 41};
    const auto part = render_scene(scene, settings, &sky);
    EXPECT_EQ(part.film.window.width(), 37);
    for (size_t c = 0; c < part.film.channels.size(); ++c) {
        const Channel &p = part.film.channels[c], &w = whole.film.channels[c];
        for (int y = 7; y < 41; ++y) {
            for (int x = 13; x < 50; ++x) {
                const auto ip = static_cast<size_t>((y - 7) * 37 + x - 13);
                const auto iw = static_cast<size_t>(y * 64 + x);
                if (p.values.empty()) {
                    ASSERT_EQ(p.integers[ip], w.integers[iw]) << p.name;
                } else {
                    ASSERT_EQ(std::bit_cast<uint32_t>(p.values[ip]),
                              std::bit_cast<uint32_t>(w.values[iw]))
                        << p.name << " at " << x << "," << y;
                }
            }
        }
    }
}

TEST(Render, ACropEqualsThatPartOfTheWhole) { expect_equal_crop(rich_settings(4)); }

TEST(Render, ACropOfAPictureSampledByErrorEqualsThatPartOfTheWhole) {
    RenderSettings settings = rich_settings(1);
    settings.error = 0.05f;
    expect_equal_crop(settings);
}

TEST(Render, AllPixelsOfARichPictureAreFinite) {
    const Environment sky = uniform_environment({0.3f, 0.4f, 0.6f});
    EXPECT_EQ(render_scene(rich_scene(), rich_settings(16), &sky).nonfinite_pixels, 0u);
}

TEST(Render, AStopAfterTheFirstBandLeavesItWholeAndOtherTilesUntraced) {
    const Scene scene = rich_scene();
    const RenderSettings settings = rich_settings(1);
    const Needs needs = find_needs(scene, settings, false);
    const auto engine = make_engine(scene, engine_name(needs), needs.embree);
    const RenderContext context(scene, settings, needs, *engine, nullptr);
    const Film whole = render_scene(scene, settings).film;
    std::stop_source source;
    const BandSink stop_at_once = [&](const Film& band) {
        if (source.stop_requested()) return;
        source.request_stop();
        EXPECT_EQ(band.window.y1, 16);
        for (int y = band.window.y0; y < band.window.y1; ++y)
            for (int x = 0; x < settings.width; ++x)
                ASSERT_EQ(beauty_at(band, x, y), beauty_at(whole, x, y)) << x << "," << y;
    };
    const RenderResult result =
        render(context, stop_at_once, {.threads = 1, .stop = source.get_token()});
    EXPECT_EQ(result.tiles, 12u);
    EXPECT_EQ(result.tiles_done, 4u);
}

TEST(Render, ACheckpointOfAStoppedRenderSavesItsTiles) {
    const Scene scene = rich_scene();
    const RenderSettings settings = rich_settings(1);
    const Needs needs = find_needs(scene, settings, false);
    const auto engine = make_engine(scene, engine_name(needs), needs.embree);
    const RenderContext context(scene, settings, needs, *engine, nullptr);
    const auto sum = [](const Counters& c) { return std::reduce(c.rays.begin(), c.rays.end()); };
    const std::string folder = test_folder() / "tiles";
    RenderResult stopped;
    {
        Checkpoint checkpoint(folder, 1);
        std::stop_source source;
        RenderRun run{.threads = 1};
        run.stop = source.get_token();
        run.checkpoint = &checkpoint;
        stopped = render(
            context, [&](const Film&) { source.request_stop(); }, run);
    }
    EXPECT_EQ(stopped.tiles_done, 4u);
    Checkpoint checkpoint(folder, 1);
    EXPECT_EQ(missing_tiles(settings, checkpoint), 8u);
    RenderRun run;
    run.record_rays = true;
    run.checkpoint = &checkpoint;
    const RenderedScene resumed = render_scene(scene, settings, nullptr, nullptr, run);
    const RenderedScene whole = render_scene(scene, settings);
    expect_same_film(resumed.film, whole.film);
    EXPECT_EQ(resumed.counters.rays, whole.counters.rays);
    EXPECT_EQ(resumed.rays.size(), sum(whole.counters) - sum(stopped.counters))
        << "finished tiles are not traced again";
    EXPECT_EQ(missing_tiles(settings, Checkpoint(folder, 1)), 0u);
}

TEST(Render, AllCountedRaysAreRecorded) {
    const Scene scene = rich_scene();
    const auto result = render_scene(scene, rich_settings(1), nullptr, nullptr,
                                     {.record_rays = true, .show_progress = false, .stop = {}});
    std::array<uint64_t, ray_kinds> counts{};
    for (const RecordedRay& r : result.rays) ++counts[static_cast<size_t>(r.kind)];
    EXPECT_EQ(counts, result.counters.rays);
    EXPECT_GT(counts[3], 0u);
}

}  // namespace
}  // namespace sightline
