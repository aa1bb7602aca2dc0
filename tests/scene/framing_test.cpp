// How views frame what they show: known pictures first, then properties of random scenes.
#include "output/camera_choice.h"
#include "output/render_asset.h"
#include "render/camera_rays.h"
#include "support/gltf.h"
#include "support/pictures.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

namespace sightline {
namespace {

/// What points cover of a picture: the coordinates, 0 to 1 from the left and from the bottom.
struct Covered {
    Vec2 low{2, 2}, high{-2, -2};

    void add(const Mat4& to_ndc, const Vec3& p) {
        const Vec4 h = Vec4(p.x, p.y, p.z, 1) * to_ndc;
        EXPECT_GT(h.w, 0);
        const Vec2 at(h.x / h.w, h.y / h.w);
        low = {std::min(low.x, at.x), std::min(low.y, at.y)};
        high = {std::max(high.x, at.x), std::max(high.y, at.y)};
    }
};

RenderCommand command_of(const std::string& view, int width = 1000, int height = 1000) {
    RenderCommand command;
    command.view.camera = view;
    command.settings.width = width;
    command.settings.height = height;
    return command;
}

Mat4 to_ndc(const RenderCommand& command, const Scene& scene) {
    return CameraRays(complete_settings(command, scene), scene.bounds).world_to_ndc();
}

Covered cover(const RenderCommand& command, const Scene& scene) {
    const Mat4 matrix = to_ndc(command, scene);
    Covered covered;
    for (const Instance& instance : scene.instances)
        for (const uint32_t m : scene.groups[instance.group].meshes)
            for (const Vec3& p : scene.meshes[m].positions)
                covered.add(matrix, transform_point(p, instance.object_to_world));
    return covered;
}

/// Fills the picture in one dimension up to the margin, and lies in its middle: each within a
/// fiftieth of a pixel of 1000.
void expect_framed(const Covered& c, float margin, const std::string& what) {
    constexpr float tolerance = 2e-5f;
    EXPECT_NEAR(c.low.x + c.high.x, 1, 2 * tolerance) << what;
    EXPECT_NEAR(c.low.y + c.high.y, 1, 2 * tolerance) << what;
    EXPECT_NEAR(std::min(c.low.x, c.low.y), margin, tolerance) << what;
}

Mesh box_between(const Vec3& low, const Vec3& high) {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.positions.emplace_back(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y,
                                    i & 4 ? high.z : low.z);
    mesh.triangles = {{0, 1, 2}, {5, 6, 7}, {3, 4, 5}};
    return mesh;
}

Scene scene_of(Mesh mesh) {
    SceneBuilder builder;
    builder.add_instance(builder.add_mesh(std::move(mesh)));
    return builder.finish();
}

Vec3 eye_of(const Camera& camera) {
    return {camera.to_world[3][0], camera.to_world[3][1], camera.to_world[3][2]};
}

TEST(Framing, ASquarePlateFillsThePictureUpToTheMargin) {
    const Scene scene = scene_of(box_between({-1, 1, 2}, {3, 5, 2}));
    RenderCommand command = command_of("front");
    command.view.margin = 10.0f;
    const Camera camera = complete_settings(command, scene).camera;
    // Half the plate, 2, is 0.8 of tan 22.5° times the distance.
    const Vec3 expected(1, 3, 2 + 2 / (0.8f * std::tan(pi / 8)));
    EXPECT_LT((eye_of(camera) - expected).length(), 1e-5f);
    command.view.ortho = true;
    EXPECT_FLOAT_EQ(complete_settings(command, scene).camera.ymag, 2.5f);
    command.view.fov = 90.0f;
    command.view.ortho = false;
    EXPECT_NEAR(eye_of(complete_settings(command, scene).camera).z, 4.5f, 1e-5f);
}

TEST(Framing, TheNearSideOfABoxDecides) {
    const Scene scene = scene_of(box_between({-1, -1, -9}, {1, 1, 1}));
    RenderCommand command = command_of("front");
    command.view.margin = 0.0f;
    EXPECT_NEAR(eye_of(complete_settings(command, scene).camera).z, 1 + 1 / std::tan(pi / 8),
                1e-5f);
}

TEST(Framing, RandomScenesFillOneDimensionAndLieInTheMiddleOfPicturesOfAnyShape) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> number(-1, 1);
    const std::pair<int, int> sizes[] = {{1000, 1000}, {1000, 250}, {300, 1200}};
    for (int i = 0; i < 60; ++i) {
        const Vec3 stretch(std::exp(3 * number(random)), std::exp(3 * number(random)),
                           std::exp(3 * number(random)));
        Mesh cloud;
        for (int k = 0; k < 700; ++k) {
            const Vec3 p(number(random), number(random), number(random));
            cloud.positions.push_back(p * stretch + Vec3(5, -3, 2));
        }
        cloud.triangles = {{0, 1, 2}};
        SceneBuilder builder;
        const uint32_t group = builder.add_mesh(std::move(cloud), 0);
        Mat4 turn;
        turn.setAxisAngle(normalize(Vec3(1, 2, 3)), number(random) * 3);
        builder.add_instance(group, turn);
        builder.add_instance(group, turn * Mat4().setTranslation(Vec3(number(random), 0, 2)));
        const Scene scene = builder.finish();
        const auto& [width, height] = sizes[i % 3];
        RenderCommand command = command_of(
            fmt::format("{}/{}", 180 * number(random), 90 * number(random)), width, height);
        command.view.ortho = i % 2 != 0;
        command.view.margin = static_cast<float>(i % 7);
        expect_framed(cover(command, scene), *command.view.margin / 100,
                      fmt::format("scene {} from {}", i, command.view.camera));
    }
}

TEST(Framing, EachAnalyticShapeFillsThePicture) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> number(-1, 1);
    for (const ShapeKind kind :
         {ShapeKind::sphere, ShapeKind::box, ShapeKind::capsule, ShapeKind::cylinder,
          ShapeKind::plane, ShapeKind::torus, ShapeKind::heart}) {
        Shape shape;
        shape.kind = kind;
        shape.radius_top = 0.1f;
        shape.to_object = Mat4d().setAxisAngle(Vec3d(1, 0, 2), 0.7) *
                          Mat4d().setTranslation(Vec3d(0.3, 0.2, 0.1));
        SceneBuilder builder;
        builder.add_instance(builder.add_shape(shape, 0));
        const Scene scene = builder.finish();
        RenderCommand command = command_of("30/20", 256, 256);
        command.view.margin = 25.0f;
        RenderSettings settings = complete_settings(command, scene);
        settings.samples = 16;
        settings.background = Background::transparent;
        const Film film = render_scene(scene, settings).film;
        int x0 = 256, x1 = -1, y0 = 256, y1 = -1;
        for (int y = 0; y < 256; ++y)
            for (int x = 0; x < 256; ++x)
                if (film.find("A")->values[static_cast<size_t>(y * 256 + x)] > 0) {
                    x0 = std::min(x0, x), x1 = std::max(x1, x);
                    y0 = std::min(y0, y), y1 = std::max(y1, y);
                }
        const int kind_number = static_cast<int>(kind);
        // Pixels 64 to 191; a sharp corner may cover too little of its last pixel for a sample.
        EXPECT_NEAR(std::min(x0, y0), 64, 1) << kind_number;
        EXPECT_NEAR(std::max(x1, y1), 191, 1) << kind_number;
        EXPECT_NEAR(x0 + x1, 255, 2) << kind_number;
        EXPECT_NEAR(y0 + y1, 255, 2) << kind_number;
    }
}

TEST(Framing, ATurntableIsFramedOnceAndNothingIsCutFromAnySide) {
    const Scene scene = scene_of(box_between({-2, 0, -0.1f}, {2, 1, 0.3f}));
    RenderCommand command = command_of("10/25", 1000, 600);
    Covered all;
    for (int i = 0; i < 360; ++i) {
        command.view.orbit = static_cast<float>(i);
        const Covered one = cover(command, scene);
        all.low = {std::min(all.low.x, one.low.x), std::min(all.low.y, one.low.y)};
        all.high = {std::max(all.high.x, one.high.x), std::max(all.high.y, one.high.y)};
    }
    // Between two of the 360 pictures, a corner moves by less than 1e-4.
    EXPECT_NEAR(std::min(all.low.x, all.low.y), 0.05f, 1e-4f);
    EXPECT_NEAR(all.low.x + all.high.x, 1, 1e-4f);
    EXPECT_NEAR(all.low.y + all.high.y, 1, 1e-4f);
    command.view.frame_each = true;
    for (const float orbit : {0.0f, 77.0f}) {
        command.view.orbit = orbit;
        expect_framed(cover(command, scene), 0.05f, fmt::format("orbit {}", orbit));
    }
}

TEST(Framing, AnAnimationIsFramedOnceAndNothingIsCutInAnyFrame) {
    GltfBuilder file;
    file.triangle();
    file.json["scenes"] = {{{"nodes", {0}}}};
    const size_t times = file.floats({0, 0.5f, 1}, "SCALAR");
    file.json["accessors"][times].update({{"min", {0}}, {"max", {1}}});
    const size_t places = file.floats({0, 0, 0, 3, 1, -5, -1, 0, 2}, "VEC3");
    file.add(
        "animations",
        {{"samplers", {{{"input", times}, {"output", places}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}});
    RenderCommand command = command_of("20/10", 640, 480);
    command.asset = file.save();
    command.view.frame_for = FrameRange{0, 4, 4};
    // A turntable of the same frames needs other points, which must not be taken for these.
    command.view.orbit = 0.0f;
    complete_settings(command, load_gltf(command.asset));
    command.view.orbit.reset();
    Covered all;
    Mat4 first;
    for (int frame = 0; frame <= 4; ++frame) {
        command.load.time = static_cast<float>(frame) / 4;
        const Scene scene = load_gltf(command.asset, command.load);
        const Mat4 camera = complete_settings(command, scene).camera.to_world;
        if (frame == 0) first = camera;
        EXPECT_EQ(camera, first) << frame;
        const Covered one = cover(command, scene);
        all.low = {std::min(all.low.x, one.low.x), std::min(all.low.y, one.low.y)};
        all.high = {std::max(all.high.x, one.high.x), std::max(all.high.y, one.high.y)};
    }
    expect_framed(all, 0.05f, "all frames");
    command.view.frame_each = true;
    expect_framed(cover(command, load_gltf(command.asset, command.load)), 0.05f, "the last frame");
}

TEST(Framing, WhatCannotBeSeenDoesNotCount) {
    Material clear, cut;
    clear.alpha_mode = AlphaMode::blend;
    clear.base_color_factor.w = 0;
    cut.alpha_mode = AlphaMode::mask;
    cut.base_color_factor.w = 0.4f;
    SceneBuilder builder;
    draw(builder, box_between({-1, -1, 0}, {1, 1, 0}), Material());
    draw(builder, box_between({-9, -1, 0}, {5, 1, 0}), clear);
    draw(builder, box_between({-1, -9, 0}, {1, 5, 0}), cut);
    Shape ground;
    ground.kind = ShapeKind::plane;
    ground.size = {0, 0, 0};
    builder.add_instance(builder.add_shape(ground, 0));
    const Camera camera = complete_settings(command_of("front"), builder.finish()).camera;
    EXPECT_LT((eye_of(camera) - Vec3(0, 0, 1 / (0.9f * std::tan(pi / 8)))).length(), 1e-5f);
}

TEST(Framing, DegenerateScenesGiveFiniteCamerasInFrontOfThem) {
    const Scene scenes[] = {Scene(), scene_of(box_between({2, 2, 2}, {2, 2, 2})),
                            scene_of(box_between({-1, 0, 0}, {1, 0, 0})),
                            scene_of(box_between({0, -1, -1}, {0, 1, 1})),
                            scene_of(box_between(Vec3(-1e18f), Vec3(1e18f)))};
    for (const Scene& scene : scenes)
        for (const char* view : {"front", "right", "top", "iso"})
            for (const bool ortho : {false, true}) {
                RenderCommand command = command_of(view);
                command.view.ortho = ortho;
                const Camera camera = complete_settings(command, scene).camera;
                EXPECT_TRUE(is_finite(camera.to_world)) << view;
                const Vec3 centre = scene.bounds.isEmpty() ? Vec3(0) : scene.bounds.center();
                const Vec3 towards(camera.to_world[2][0], camera.to_world[2][1],
                                   camera.to_world[2][2]);
                EXPECT_GT(dot(eye_of(camera) - centre, towards), 0) << view;
                EXPECT_GT(camera.ymag, 0);
            }
}

}  // namespace
}  // namespace sightline
