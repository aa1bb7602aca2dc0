#include "support/pictures.h"

namespace sightline {
namespace {

Needs forced(const Needs& found, const RenderSettings& settings) {
    Needs all = all_needs(settings);
    all.embree = found.embree;  // another build may decide ties between surfaces otherwise
    return all;
}

Scene plain_scene() {
    SceneBuilder builder;
    draw(builder, quad_mesh({-4, -1, 4}, {8, 0, 0}, {0, 0, -8}), matte({0.8f, 0.4f, 0.2f}));
    draw(builder, ball({0, 0, 0}, 1), matte({0.2f, 0.4f, 0.8f}));
    builder.add_light(point_light({3, 4, 3}, 30));
    return builder.finish();
}

std::string choice(const Needs& needs, const std::string& name) {
    for (const Decision& decision : needs.report)
        if (decision.name == name) return decision.choice;
    return "not reported";
}

TEST(Needs, APlainSceneNeedsOnlyShadowRays) {
    const Needs needs = find_needs(plain_scene(), rich_settings(1), false);
    EXPECT_FALSE(needs.coloured_shadows);
    EXPECT_FALSE(needs.volumes);
    EXPECT_FALSE(needs.area_lights);
    EXPECT_FALSE(needs.environment_light);
    EXPECT_FALSE(needs.secondary_rays);
    EXPECT_FALSE(needs.pass_through);
    EXPECT_EQ(needs.depth, 0);
    EXPECT_EQ(choice(needs, "depth"), "0");
}

TEST(Needs, ARichSceneNeedsEverything) {
    const Needs needs = find_needs(rich_scene(), rich_settings(1), true);
    for (const Decision& decision : needs.report) {
        if (decision.name == "mipmaps") continue;  // the scene has no textures
        EXPECT_NE(decision.choice, "off") << decision.name;
    }
}

// First proof: the picture with only the needs is that with everything.
TEST(Needs, ThePictureIsBitIdenticalWithEverythingForcedOn) {
    const Environment sky = uniform_environment({0.3f, 0.4f, 0.6f});
    const RenderSettings settings = rich_settings(4);
    for (const Scene& scene : {plain_scene(), rich_scene()}) {
        const Needs needs = find_needs(scene, settings, true);
        const Needs all = forced(needs, settings);
        expect_same_film(render_scene(scene, settings, &sky, &needs).film,
                         render_scene(scene, settings, &sky, &all).film);
    }
}

// Second proof: no need is on in vain.
TEST(Needs, EveryNeedIsUsed) {
    const Environment sky = uniform_environment({0.3f, 0.4f, 0.6f});
    const RenderSettings settings = rich_settings(4);
    for (const Scene& scene : {plain_scene(), rich_scene()}) {
        const Needs needs = find_needs(scene, settings, true);
        EXPECT_EQ(unused_needs(needs, render_scene(scene, settings, &sky, &needs).counters),
                  std::vector<std::string>{});
    }
    const Needs all = all_needs(settings);
    EXPECT_FALSE(
        unused_needs(all, render_scene(plain_scene(), settings, nullptr, &all).counters).empty());
}

// Third proof: each need is necessary.
TEST(Needs, RemovingAnyNeedChangesThePicture) {
    const Scene scene = rich_scene();
    const Environment sky = uniform_environment({0.3f, 0.4f, 0.6f});
    const RenderSettings settings = rich_settings(4);
    const Needs needs = find_needs(scene, settings, true);
    const auto whole = render_scene(scene, settings, &sky, &needs);
    for (bool Needs::*need :
         {&Needs::pass_through, &Needs::coloured_shadows, &Needs::volumes, &Needs::area_lights,
          &Needs::environment_light, &Needs::secondary_rays}) {
        ASSERT_TRUE(needs.*need);
        Needs less = needs;
        less.*need = false;
        const auto film = render_scene(scene, settings, &sky, &less).film;
        EXPECT_FALSE(same_bits(film.channels[0], whole.film.channels[0]));
    }
}

TEST(Needs, AGlossinessTextureMayMakeAMirrorRough) {
    Material mirror = matte({0, 0, 0});
    mirror.specular_factor = 1;
    mirror.roughness_factor = 0;
    Scene scene = scene_of(ball({0, 0, 0}, 1), mirror);
    const RenderSettings settings =
        small_settings(look_at({0, 0, 6}, {0, 0, 0}, {0, 1, 0}, pi / 4));
    EXPECT_FALSE(find_needs(scene, settings, false).noise);
    scene.textures.resize(1);
    scene.materials[1].glossiness_texture.texture = 0;
    EXPECT_TRUE(find_needs(scene, settings, false).noise);
}

TEST(Needs, DepthEndsWhereNothingBringsTheCutoffAnyMore) {
    Scene scene = plain_scene();
    scene.lights.clear();
    RenderSettings settings = rich_settings(1);
    settings.depth = 100;
    settings.cutoff = 0.5f / 255;
    scene.materials[1].roughness_factor = 0;    // exact: rough lobes have a margin
    scene.materials[1].specular_factor = 0.5f;  // log(1/510) / log(0.5) = 8.99
    EXPECT_EQ(find_needs(scene, settings, false).depth, 8);
    scene.materials[1].emissive_factor = Vec3(100);  // log(1/51000) / log(0.5) = 15.6
    EXPECT_EQ(find_needs(scene, settings, false).depth, 15);
    EXPECT_EQ(find_needs(scene, settings, true).depth, 100) << "a sky may be as bright as a sun";
    settings.depth = 5;
    EXPECT_EQ(find_needs(scene, settings, false).depth, 5);
    settings.depth = 100;
    scene.materials[2].metallic_factor = 1;  // reflects all light at grazing angles
    EXPECT_EQ(find_needs(scene, settings, false).depth, 100);
}

}  // namespace
}  // namespace sightline
