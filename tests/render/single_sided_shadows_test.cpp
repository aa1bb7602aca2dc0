// Pictures of what is seen through culled faces. Right values are those of the same scene without
// the faces that the light passes, or follow from the law of a Lambertian surface.
#include "intersect/engines.h"
#include "support/single_sided.h"

namespace sightline {
namespace {

constexpr float sun_lux = 3;

/// A sun that shines along `direction`.
Light sun(const Vec3& direction) {
    Light light;
    light.kind = LightKind::directional;
    light.direction = normalize(direction);
    light.intensity = sun_lux;
    return light;
}

/// What a white Lambertian surface sends back of a sun whose direction has this cosine.
float sunlit(float cosine) { return sun_lux * cosine / pi; }

/// A narrow view of one point.
RenderSettings view(const Vec3& from, const Vec3& at, int samples = 1) {
    const Vec3 up = from.x == at.x && from.z == at.z ? Vec3(0, 0, -1) : Vec3(0, 1, 0);
    return small_settings(look_at(from, at, up, 0.01f), samples, 5, 5);
}

/// Radiance of the point in the middle of the view.
Vec3 seen(const Scene& scene, const RenderSettings& settings,
          const Environment* environment = nullptr) {
    return beauty_at(render_scene(scene, settings, environment).film, 2, 2);
}

struct Room {
    bool near_wall = true, others = true;

    /// Walls at x = ±1, z = ±1, y = 0 and 2 that look inwards, under a sun from above and before.
    Scene scene() const {
        SceneBuilder builder;
        const uint32_t wall = builder.add_material(single_sided(Vec3(1)));
        const auto add = [&](const Mesh& mesh) {
            builder.add_instance(builder.add_mesh(mesh, wall));
        };
        add(floor_mesh(0, 1));
        add(quad_mesh({-1, 0, -1}, {2, 0, 0}, {0, 2, 0}));
        if (near_wall) add(turned(quad_mesh({-1, 0, 1}, {2, 0, 0}, {0, 2, 0})));
        if (others) {
            add(turned(floor_mesh(2, 1)));
            add(quad_mesh({-1, 0, 1}, {0, 0, -2}, {0, 2, 0}));
            add(turned(quad_mesh({1, 0, 1}, {0, 0, -2}, {0, 2, 0})));
        }
        builder.add_light(sun({0, -1, -1}));
        return builder.finish();
    }
};

const Vec3 before_the_room(0, 1, 6), in_the_room(0, 1, 0.9f);
const Vec3 on_its_floor(0.1f, 0, -0.2f), on_its_back_wall(0.1f, 1, -1);

TEST(SingleSidedShadows, ABallInsideOutIsLitWithin) {
    SceneBuilder builder;
    draw(builder, inside_out_ball({0, 0, 0}, 1), single_sided(Vec3(1)));
    builder.add_light(sun({0, 0, -1}));
    const Scene scene = builder.finish();
    RenderSettings settings = view({0, 0, 6}, {0, 0, 0});
    // The far side, through the near one. Vertex normals of 64 columns deviate by less than 1e-4.
    EXPECT_NEAR(seen(scene, settings).x, sunlit(1), 1e-4f);
    settings.single_sided_shadows = SingleSidedShadows::on;
    EXPECT_EQ(seen(scene, settings), Vec3(0));
}

TEST(SingleSidedShadows, ARoomIsLitThroughTheWallThatTheViewLooksThrough) {
    const Scene room = Room().scene(), floor_and_back = Room{false, false}.scene();
    for (const Vec3& at : {on_its_floor, on_its_back_wall}) {
        const float there = seen(room, view(before_the_room, at)).x;
        EXPECT_NEAR(there, sunlit(std::sqrt(0.5f)), 1e-6f);
        EXPECT_NEAR(there, seen(floor_and_back, view(before_the_room, at)).x, 1e-6f);
    }
}

TEST(SingleSidedShadows, WithinAClosedRoomTheSunDoesNotShine) {
    for (const Vec3& at : {on_its_floor, on_its_back_wall})
        EXPECT_EQ(seen(Room().scene(), view(in_the_room, at)), Vec3(0));
}

TEST(SingleSidedShadows, ACeilingHoldsTheSunOffIfNothingIsSeenThroughACulledFace) {
    const Scene open = Room{.near_wall = false}.scene();
    RenderSettings settings =
        small_settings(look_at(before_the_room, {0, 1, 0}, {0, 1, 0}, 0.5f), 1, 49, 49);
    const Film film = render_scene(open, settings).film;
    EXPECT_EQ(beauty_at(film, 24, 24), Vec3(0));
    EXPECT_NEAR(seen(open, view(before_the_room, {0.1f, 0, 0.8f})).x, sunlit(std::sqrt(0.5f)),
                1e-6f);
}

TEST(SingleSidedShadows, AnOutlineShadesNothingAndStaysBlack) {
    const auto picture = [](bool outlined) {
        SceneBuilder builder;
        draw(builder, ball({0, 0, 0}, 1), single_sided(Vec3(1)));
        if (outlined) draw(builder, inside_out_ball({0, 0, 0}, 1.1f), unlit(Vec3(0)));
        builder.add_light(sun({0, 0, -1}));
        RenderSettings settings =
            small_settings(look_at({0, 0, 6}, {0, 0, 0}, {0, 1, 0}, 0.5f), 1, 65, 65);
        settings.background_color = Vec3(1, 1, 1);
        return render_scene(builder.finish(), settings).film;
    };
    const Film plain = picture(false), outlined = picture(true);
    EXPECT_NEAR(beauty_at(outlined, 32, 32).x, beauty_at(plain, 32, 32).x, 1e-5f);
    EXPECT_NEAR(beauty_at(outlined, 24, 38).x, beauty_at(plain, 24, 38).x, 1e-3f);
    // 1.05 units from the middle: 2 · 6 tan(0.25) = 3.06 units for 65 pixels.
    EXPECT_EQ(beauty_at(outlined, 32 + 22, 32), Vec3(0));
    EXPECT_EQ(beauty_at(plain, 32 + 22, 32), Vec3(1, 1, 1));
}

TEST(SingleSidedShadows, ASkyDomeLetsTheSunAndTheEnvironmentIn) {
    const auto floor = [](bool domed) {
        SceneBuilder builder;
        draw(builder, floor_mesh(0, 30), matte(Vec3(1)));
        if (domed) draw(builder, inside_out_ball({0, 0, 0}, 20), unlit({0, 0, 1}));
        return builder.finish();
    };
    const Environment white = uniform_environment({1, 1, 1});
    const RenderSettings settings = view({0, 2, 3}, {0, 0, 0}, 256);
    Scene scene = floor(true);
    EXPECT_NEAR(seen(scene, settings, &white).x, seen(floor(false), settings, &white).x, 1e-5f);
    scene.lights.push_back(sun({0, -1, 0}));
    EXPECT_NEAR(seen(scene, settings).x, sunlit(1), 1e-5f);  // rounding
}

// Three balls over a box, all closed and looking outwards.
TEST(SingleSidedShadows, ClosedMeshesThatLookOutwardsKeepEveryBit) {
    Material plastic = single_sided({0.8f, 0.3f, 0.2f});
    plastic.specular_factor = 1;
    plastic.roughness_factor = 0.3f;
    Shape box;
    box.kind = ShapeKind::box;
    box.size = {8, 1, 8};
    box.to_object.setTranslation(Vec3d(0, -1.5, 0));
    SceneBuilder builder;
    const uint32_t m = builder.add_material(plastic);
    builder.add_instance(builder.add_shape(box, m));
    const uint32_t balls = builder.add_mesh(ball({0, 0, 0}, 1), m);
    builder.add_instance(balls, Mat4().setTranslation(Vec3(-1.1f, 0, 0)));
    Mat4 mirrored;
    mirrored.setScale(Vec3(-1, 1, 1));
    builder.add_instance(balls, mirrored * Mat4().setTranslation(Vec3(1.1f, 0, 0.5f)));
    draw(builder, ball({0, 3, 0}, 0.4f), plastic);
    builder.add_light(point_light({3, 4, 3}, 30));
    builder.add_light(sun({-1, -1, -1}));
    const Scene scene = builder.finish();
    const Environment sky = uniform_environment({0.3f, 0.4f, 0.6f});
    RenderSettings settings =
        small_settings(look_at({0, 1.5f, 6}, {0, 0, 0}, {0, 1, 0}, pi / 4), 4);
    const Film automatic = render_scene(scene, settings, &sky).film;
    for (const auto choice : {SingleSidedShadows::on, SingleSidedShadows::off}) {
        settings.single_sided_shadows = choice;
        expect_same_film(automatic, render_scene(scene, settings, &sky).film);
    }
}

/// A floor under a roof that looks down on it; the lights are above.
Scene under_a_roof(const Material& floor, const Material& roof, bool covered = true) {
    SceneBuilder builder;
    draw(builder, floor_mesh(0, 5), floor);
    if (covered) draw(builder, turned(floor_mesh(1, 5)), roof);
    return builder.finish();
}

const Vec3 above(0, 5, 0), origin(0, 0, 0);

TEST(SingleSidedShadows, LightOfTheEnvironmentReachesDiffuseFloorsWithWeightOne) {
    const Environment white = uniform_environment({1, 1, 1});
    const Scene scene = under_a_roof(matte(Vec3(1)), single_sided(Vec3(0)));
    RenderSettings settings = view(above, origin, 1024);
    EXPECT_NEAR(seen(scene, settings, &white).x, 1, 0.01f);
    settings.single_sided_shadows = SingleSidedShadows::on;
    // Between floor and roof, from the sides: sin² of the angle above the horizon, within bounds.
    EXPECT_LT(seen(scene, settings, &white).x, 0.05f);
}

// A black roof: what a lobe finds there has no light, whether the environment passes or not.
TEST(SingleSidedShadows, GlossyLobesSeeTheEnvironmentAndLampsWhereNothingLiesBetween) {
    Material metal;
    metal.roughness_factor = 0.5f;
    metal.double_sided = true;
    Material lamp = matte(Vec3(0));
    lamp.emissive_factor = {5, 4, 3};
    SceneBuilder builder;
    draw(builder, floor_mesh(0, 5), metal);
    draw(builder, turned(quad_mesh({0, 1, 5}, {5, 0, 0}, {0, 0, -10})), single_sided(Vec3(0)));
    draw(builder, turned(floor_mesh(3, 1)), lamp);
    const Scene scene = builder.finish();
    const Environment white = uniform_environment({1, 1, 1});
    for (const int depth : {0, 8}) {
        RenderSettings settings =
            small_settings(look_at({4, 6, 0.5f}, origin, {0, 1, 0}, 0.5f), 16, 24, 24);
        settings.depth = depth;
        const Film automatic = render_scene(scene, settings, &white).film;
        EXPECT_GT(beauty_at(automatic, 12, 12).x, 0.2f);
        settings.single_sided_shadows = SingleSidedShadows::on;
        expect_same_film(automatic, render_scene(scene, settings, &white).film);
    }
}

// Rays of a lobe pass an undrawn back that holds off the light: there they alone count.
TEST(SingleSidedShadows, WhatALobeSeesThroughABackIsCountedOnce) {
    Material metal;
    metal.roughness_factor = 0.6f;
    metal.double_sided = true;
    SceneBuilder builder;
    draw(builder, floor_mesh(0, 1), metal);
    draw(builder, floor_mesh(1, 50), single_sided(Vec3(0)));
    const Scene scene = builder.finish();
    const Environment white = uniform_environment({1, 1, 1});
    const RenderSettings settings = view({0, 0.8f, 0.3f}, origin, 1024);
    Needs needs = find_needs(scene, settings, true);
    const float both = beauty_at(render_scene(scene, settings, &white, &needs).film, 2, 2).y;
    needs.environment_light = false;
    const float lobe_alone = beauty_at(render_scene(scene, settings, &white, &needs).film, 2, 2).y;
    EXPECT_GT(lobe_alone, 0.8f);
    EXPECT_NEAR(both, lobe_alone, 0.001f);  // the roof hides all but the horizon from light samples
}

TEST(SingleSidedShadows, PointsAndLampsShineThroughARoofAsIfItWereNotThere) {
    Material metal;
    metal.roughness_factor = 0.6f;
    metal.double_sided = true;
    for (const Material& floor : {metal, matte(Vec3(1))}) {
        const auto radiance = [&](bool covered) {
            Scene scene = under_a_roof(floor, single_sided(Vec3(0)), covered);
            scene.lights.push_back(point_light({1, 3, 0}, 10));
            return seen(scene, view(above, origin)).x;
        };
        EXPECT_GT(radiance(false), 0.1f);
        EXPECT_NEAR(radiance(true), radiance(false), 1e-5f);
    }
    const auto lamplit = [&](bool covered) {
        Material lamp = single_sided(Vec3(0));
        lamp.emissive_factor = {5, 4, 3};
        SceneBuilder builder;
        draw(builder, floor_mesh(0, 5), matte(Vec3(1)));
        if (covered) draw(builder, turned(floor_mesh(1, 5)), single_sided(Vec3(0)));
        draw(builder, turned(quad_mesh({1, 3, 0}, {1, 0, 0}, {0, 0, -1})), lamp);
        return seen(builder.finish(), view(above, origin, 64)).x;
    };
    EXPECT_GT(lamplit(false), 0.1f);
    EXPECT_NEAR(lamplit(true), lamplit(false), 1e-4f);
}

TEST(SingleSidedShadows, HaveNoSeamWhereARoofEnds) {
    SceneBuilder builder;
    draw(builder, floor_mesh(0, 5), matte(Vec3(1)));
    draw(builder, turned(quad_mesh({0, 1, 2}, {5, 0, 0}, {0, 0, -4})), single_sided(Vec3(1)));
    builder.add_light(sun({-1, -1, 0.3f}));
    const Film film =
        render_scene(builder.finish(), small_settings(look_at(above, origin, {0, 0, -1}, 0.6f)))
            .film;
    const auto& values = film.find("R")->values;
    const auto [least, most] = std::ranges::minmax_element(values);
    EXPECT_NEAR(*least, sunlit(1 / std::sqrt(2.09f)), 1e-5f);
    EXPECT_NEAR(*most, *least, 1e-5f);
}

// The front of a roof that covers a quarter of a blend, or has holes, attenuates; its back does
// not.
TEST(SingleSidedShadows, OfBlendedAndCutOutRoofsFallFromTheirFrontsAlone) {
    Material blend = single_sided(Vec3(0)), mask = blend;
    blend.alpha_mode = AlphaMode::blend;
    blend.base_color_factor.w = 0.25f;
    mask.alpha_mode = AlphaMode::mask;
    const auto radiance = [](const Material& roof, bool looks_up) {
        SceneBuilder builder;
        draw(builder, floor_mesh(0, 5), matte(Vec3(1)));
        // Over the floor's half x > 0; the other half is in view.
        const Mesh half = quad_mesh({0, 1, 5}, {5, 0, 0}, {0, 0, -10});
        draw(builder, looks_up ? half : turned(half), roof);
        builder.add_light(sun({-1, -1, 0}));
        RenderSettings settings =
            small_settings(look_at(above, origin, {0, 0, -1}, 0.6f), 1, 65, 65);
        return beauty_at(render_scene(builder.finish(), settings).film, 30, 32).x;
    };
    const float full = sunlit(std::sqrt(0.5f));
    for (const Material& roof : {blend, mask, single_sided(Vec3(0))})
        EXPECT_NEAR(radiance(roof, false), full, 1e-5f);
    EXPECT_NEAR(radiance(blend, true), 0.75f * full, 1e-5f);
    EXPECT_EQ(radiance(mask, true), 0);
    EXPECT_EQ(radiance(single_sided(Vec3(0)), true), 0);
}

TEST(SingleSidedShadows, CrossGlassAndItsInteriorBeneathARoof) {
    Material glass = matte(Vec3(1));
    glass.ior = 1;
    glass.roughness_factor = 0;
    glass.transmission_factor = 1;
    glass.thickness_factor = 1;
    glass.attenuation_distance = 1;
    glass.attenuation_color = {0.5f, 0.5f, 0.5f};
    SceneBuilder builder;
    draw(builder, floor_mesh(0, 5), matte(Vec3(1)));
    const uint32_t m = builder.add_material(glass);
    builder.add_instance(builder.add_mesh(turned(quad_mesh({0, 1, 5}, {5, 0, 0}, {0, 0, -10})), m));
    builder.add_instance(builder.add_mesh(quad_mesh({0, 2, 5}, {5, 0, 0}, {0, 0, -10}), m));
    draw(builder, turned(floor_mesh(3, 5)), single_sided(Vec3(0)));
    builder.add_light(sun({-1, -1, 0}));
    // The view meets roof and floor; the sun arrives through roof and glass.
    const float got = seen(builder.finish(), view({-0.01f, 5, 0}, {-0.01f, 0, 0})).x;
    EXPECT_NEAR(got, sunlit(std::sqrt(0.5f)) * std::pow(0.5f, std::sqrt(2.0f)), 1e-5f);
}

TEST(SingleSidedShadows, AreTheSameWithEveryEngine) {
    Scene scene = under_a_roof(matte({1, 0.5f, 0.2f}), single_sided(Vec3(1)));
    scene.lights.push_back(sun({-1, -2, 0.5f}));
    const RenderSettings settings = small_settings(look_at({1, 4, 5}, origin, {0, 1, 0}, 0.8f));
    const Needs needs = find_needs(scene, settings, false);
    std::vector<Film> films;
    for (const char* engine : {"embree", "embree-default", "few-shapes", "exact"}) {
        const auto intersector = make_engine(scene, engine, needs.embree);
        const RenderContext context(scene, settings, needs, *intersector, nullptr);
        Film film = blank_film(context.layers.layout, window_of(settings));
        render(context, [&](const Film& band) { copy_pixels(film, band, band.window); });
        films.push_back(std::move(film));
    }
    EXPECT_NEAR(beauty_at(films[0], 32, 24).x, sunlit(2 / std::sqrt(5.25f)), 1e-5f);
    for (const Film& film : films)
        for (size_t i = 0; i < film.find("R")->values.size(); ++i)
            ASSERT_NEAR(film.find("R")->values[i], films[0].find("R")->values[i], 1e-5f);
}

TEST(SingleSidedShadows, AreTheSameForAnyThreadsAndCrop) {
    SceneBuilder builder;
    draw(builder, floor_mesh(-1, 5), matte({0.5f, 0.7f, 0.9f}));
    draw(builder, inside_out_ball({0.5f, 0, 0}, 1), single_sided({0.9f, 0.5f, 0.2f}));
    builder.add_light(sun({-1, -1, -1}));
    const Scene scene = builder.finish();
    const Environment sky = uniform_environment({0.3f, 0.4f, 0.6f});
    RenderSettings settings =
        small_settings(look_at({0, 1.5f, 6}, {0, 0, 0}, {0, 1, 0}, pi / 4), 4);
    const Film one = render_scene(scene, settings, &sky, nullptr, {.threads = 1}).film;
    expect_same_film(one, render_scene(scene, settings, &sky, nullptr, {.threads = 3}).film);
    settings.crop = {0, 20, 20, 48};  // without the ball
    const Film crop = render_scene(scene, settings, &sky).film;
    for (int y = 20; y < 48; ++y)
        for (int x = 0; x < 20; ++x) ASSERT_EQ(beauty_at(crop, x, y), beauty_at(one, x, y));
}

}  // namespace
}  // namespace sightline
