#include "render/single_sided.h"

#include "intersect/engines.h"
#include "support/single_sided.h"

namespace sightline {
namespace {

/// A view along −z from z = 6 that shows some 5 units of the plane z = 0.
RenderSettings front_view(int samples = 1) {
    return small_settings(look_at({0, 0, 6}, {0, 0, 0}, {0, 1, 0}, pi / 4), samples, 48, 48);
}

/// The indices of the materials that light passes in this view.
std::vector<uint32_t> passing(const Scene& scene, const RenderSettings& settings,
                              const char* engine = "embree") {
    const Needs needs = find_needs(scene, settings, false);
    const auto intersector = make_engine(scene, engine, needs.embree);
    const RenderContext context(scene, settings, needs, *intersector, nullptr);
    std::vector<uint32_t> result;
    for (uint32_t m = 0; m < context.single_sided.pass_light.size(); ++m)
        if (context.single_sided.pass_light[m]) result.push_back(m);
    return result;
}

std::string explanation(const Scene& scene, const RenderSettings& settings) {
    const Needs needs = find_needs(scene, settings, false);
    const auto intersector = make_embree(scene, needs.embree);
    const RenderContext context(scene, settings, needs, *intersector, nullptr);
    const Decision& decision = context.single_sided.decision;
    return decision.name + " " + decision.choice + ": " + decision.because;
}

using Indices = std::vector<uint32_t>;

TEST(SingleSidedFaces, LetLightThroughWhereTheViewMeetsTheirBacks) {
    EXPECT_EQ(passing(scene_of(inside_out_ball({0, 0, 0}, 1), single_sided(Vec3(1))), front_view()),
              Indices{1});
    EXPECT_EQ(passing(scene_of(ball({0, 0, 0}, 1), single_sided(Vec3(1))), front_view()),
              Indices{});
    // From within, an outward ball is looked through and one whose faces look inwards is not.
    EXPECT_EQ(passing(scene_of(ball({0, 0, 6}, 1), single_sided(Vec3(1))), front_view()),
              Indices{1});
    EXPECT_EQ(passing(scene_of(inside_out_ball({0, 0, 6}, 1), single_sided(Vec3(1))), front_view()),
              Indices{});
}

TEST(SingleSidedFaces, HoldLightOffIfTheirBacksLieBehindWhatIsDrawn) {
    SceneBuilder builder;
    draw(builder, quad_mesh({-9, -9, 2}, {18, 0, 0}, {0, 18, 0}), single_sided(Vec3(1)));
    draw(builder, inside_out_ball({0, 0, 0}, 1), single_sided(Vec3(1)));
    EXPECT_EQ(passing(builder.finish(), front_view()), Indices{});
}

TEST(SingleSidedFaces, AreLookedThroughOneBehindTheOtherAndThroughHoles) {
    Material hole = matte(Vec3(1));
    hole.alpha_mode = AlphaMode::mask;
    hole.base_color_factor.w = 0;
    SceneBuilder builder;
    draw(builder, quad_mesh({-9, -9, 3}, {18, 0, 0}, {0, 18, 0}), hole);
    for (const float z : {2.0f, 1.0f})
        draw(builder, turned(quad_mesh({-9, -9, z}, {18, 0, 0}, {0, 18, 0})),
             single_sided(Vec3(1)));
    EXPECT_EQ(passing(builder.finish(), front_view()), (Indices{2, 3}));
}

// Leaves that are visible from both sides by a flipped copy: the copy that faces the view is drawn.
TEST(SingleSidedFaces, AreNotLookedThroughIfAFaceInTheSamePlaceIsDrawn) {
    const Mesh leaf = quad_mesh({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    for (const bool back_first : {true, false}) {
        SceneBuilder builder;
        draw(builder, back_first ? turned(leaf) : leaf, single_sided(Vec3(1)));
        draw(builder, back_first ? leaf : turned(leaf), single_sided(Vec3(1)));
        const Scene scene = builder.finish();
        for (const char* engine : {"embree", "few-shapes", "exact"})
            EXPECT_EQ(passing(scene, front_view(), engine), Indices{}) << engine;
    }
}

TEST(SingleSidedFaces, OfGlassAndDoubleSidedOnesHaveNoUndrawnBacks) {
    Material glass = single_sided(Vec3(1));
    glass.transmission_factor = 1;
    for (const Material& m : {glass, matte(Vec3(1))})
        EXPECT_EQ(passing(scene_of(inside_out_ball({0, 0, 0}, 1), m), front_view()), Indices{});
}

TEST(SingleSidedFaces, ThatAreUnlitLetLightThroughWhereverTheyAre) {
    Material both_sides = unlit(Vec3(1));
    both_sides.double_sided = true;
    SceneBuilder builder;
    draw(builder, ball({0, 0, 0}, 1), unlit(Vec3(1)));
    draw(builder, ball({3, 0, 0}, 1), both_sides);
    builder.add_material(unlit(Vec3(1)));  // no mesh has it
    EXPECT_EQ(passing(builder.finish(), front_view()), Indices{1});
}

TEST(SingleSidedFaces, OfMirroredInstancesLookWhereTheirMeshLooks) {
    for (const bool outwards : {true, false}) {
        SceneBuilder builder;
        const uint32_t group =
            builder.add_mesh(outwards ? ball({0, 0, 0}, 1) : inside_out_ball({0, 0, 0}, 1),
                             builder.add_material(single_sided(Vec3(1))));
        Mat4 mirror;
        mirror.setScale(Vec3(-1, 1, 1));
        builder.add_instance(group, mirror * Mat4().setTranslation(Vec3(-1.2f, 0, 0)));
        builder.add_instance(group, mirror * Mat4().setTranslation(Vec3(1.2f, 0, 0)));
        EXPECT_EQ(passing(builder.finish(), front_view()), outwards ? Indices{} : Indices{1});
    }
}

// A strip of a hundredth of the frame, anywhere in it.
TEST(SingleSidedFaces, AreFoundInEveryViewThatShowsThemWideEnough) {
    for (int i = 0; i < 25; ++i) {
        const float x = -2.4f + 0.19f * static_cast<float>(i);
        const Scene scene = scene_of(turned(quad_mesh({x, -9, 0}, {0.08f, 0, 0}, {0, 18, 0})),
                                     single_sided(Vec3(1)));
        EXPECT_EQ(passing(scene, front_view()), Indices{1}) << x;
    }
}

TEST(SingleSidedFaces, AreChosenOverTheWholeFrameWhateverIsRenderedOfItAndHow) {
    // In the upper left corner.
    const Scene scene = scene_of(inside_out_ball({-2, 2, 0}, 0.2f), single_sided(Vec3(1)));
    RenderSettings settings = front_view();
    settings.crop = {40, 40, 48, 48};
    settings.samples = 3;
    settings.seed = 7;
    EXPECT_EQ(passing(scene, settings), Indices{1});
    settings.aperture = 0.1f;
    settings.camera.orthographic = true;
    settings.camera.xmag = settings.camera.ymag = 3;
    for (const char* engine : {"embree", "embree-default", "woop", "exact"})
        EXPECT_EQ(passing(scene, settings, engine), Indices{1}) << engine;
}

TEST(SingleSidedFaces, ObeyTheOption) {
    SceneBuilder builder;
    draw(builder, inside_out_ball({0, 0, 0}, 1), single_sided(Vec3(1)));
    draw(builder, ball({3, 0, 0}, 1), single_sided(Vec3(1)));
    draw(builder, ball({-3, 0, 0}, 1), unlit(Vec3(1)));
    draw(builder, ball({0, 3, 0}, 1), matte(Vec3(1)));
    const Scene scene = builder.finish();
    RenderSettings settings = front_view();
    EXPECT_EQ(passing(scene, settings), (Indices{1, 3}));
    settings.single_sided_shadows = SingleSidedShadows::on;
    EXPECT_EQ(passing(scene, settings), Indices{});
    settings.single_sided_shadows = SingleSidedShadows::off;
    EXPECT_EQ(passing(scene, settings), (Indices{1, 2, 3}));
}

TEST(SingleSidedFaces, AreExplainedByNameAndReason) {
    Material wall = single_sided(Vec3(1));
    wall.name = "wa\nll";
    SceneBuilder builder;
    draw(builder, turned(quad_mesh({-90, -90, 0}, {180, 0, 0}, {0, 180, 0})), wall);
    draw(builder, ball({0, 0, 1}, 0.1f), unlit(Vec3(1)));
    draw(builder, ball({1, 0, 1}, 0.1f), single_sided(Vec3(1)));
    const Scene scene = builder.finish();
    RenderSettings settings = front_view();
    // Each ball covers a few of the rays.
    const std::string text = explanation(scene, settings);
    EXPECT_TRUE(
        text.starts_with("single_sided_shadows some: light passes the backs of 2 of 3 "
                         "single-sided materials: \"wa\\nll\" (backs met by 40"))
        << text;
    EXPECT_TRUE(text.ends_with(" of 4096 camera rays), material 2 (unlit)")) << text;
    settings.single_sided_shadows = SingleSidedShadows::on;
    EXPECT_EQ(explanation(scene, settings),
              "single_sided_shadows on: light passes the backs of 0 of 3 single-sided materials, "
              "as the option says");
    settings.single_sided_shadows = SingleSidedShadows::off;
    EXPECT_EQ(explanation(scene, settings),
              "single_sided_shadows off: light passes the backs of 3 of 3 single-sided materials, "
              "as the option says");
}

}  // namespace
}  // namespace sightline
