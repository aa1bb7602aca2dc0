#include "scene/gltf/pose.h"
#include "scene/gltf/animation.h"
#include "scene/gltf/checks.h"

#include "core/error.h"

#include <gtest/gtest.h>

#include <cstring>

namespace sightline {
namespace {

using Interpolation = GltfAnimation::Sampler::Interpolation;

/// A document made in code; each add… returns the index of the new element.
struct Builder {
    Document document;

    Builder() {
        document.path = "a.gltf";
        document.strict = true;
    }

    template <class T>
    uint32_t add(const std::vector<T>& values, ComponentType type, uint32_t rows,
                 uint32_t columns = 1, bool normalized = false) {
        auto& bytes = document.storage.emplace_back(values.size() * sizeof(T));
        if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
        GltfBufferView view;
        view.buffer = uint32_t(document.buffers.size());
        view.byte_length = bytes.size();
        document.buffers.push_back(bytes);
        GltfAccessor accessor;
        accessor.buffer_view = uint32_t(document.buffer_views.size());
        accessor.component_type = type;
        accessor.rows = rows;
        accessor.columns = columns;
        accessor.count = values.size() / (rows * columns);
        accessor.normalized = normalized;
        document.buffer_views.push_back(view);
        document.accessors.push_back(accessor);
        return uint32_t(document.accessors.size() - 1);
    }
    uint32_t add(const std::vector<float>& values, uint32_t rows = 1, uint32_t columns = 1) {
        return add(values, ComponentType::float32, rows, columns);
    }

    /// An animation of one channel of node 0.
    void animate_node(const std::string& path, uint32_t times, uint32_t output,
                      Interpolation interpolation = Interpolation::linear) {
        if (document.nodes.empty()) document.nodes.emplace_back();
        GltfAnimation& animation = document.animations.emplace_back();
        animation.samplers.push_back({times, output, interpolation});
        animation.channels.push_back({0, 0, path});
    }

    const GltfNode& at(double time, const std::string& which = "all") {
        animate(document, which, time);
        return document.nodes[0];
    }
};

template <class Call>
void expect_error(const Call& call, const std::string& expected) {
    try {
        call();
        ADD_FAILURE() << "no error: " << expected;
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()), "a.gltf: " + expected);
    }
}

TEST(Animation, LinearKeyframesAreInterpolatedAndHeldBeyondTheirEnds) {
    Builder b;
    b.animate_node("translation", b.add({1, 2, 4}), b.add({0, 0, 0, 1, 2, 3, 5, 2, 3}, 3));
    EXPECT_EQ(b.at(0).translation, Vec3d(0, 0, 0));
    EXPECT_EQ(b.at(1.25).translation, Vec3d(0.25, 0.5, 0.75));
    EXPECT_EQ(b.at(2).translation, Vec3d(1, 2, 3));
    EXPECT_EQ(b.at(3).translation, Vec3d(3, 2, 3));
    EXPECT_EQ(b.at(99).translation, Vec3d(5, 2, 3));
}

TEST(Animation, StepsChangeAtTheirKeyframes) {
    Builder b;
    b.animate_node("scale", b.add({0, 1}), b.add({1, 1, 1, 2, 2, 2}, 3), Interpolation::step);
    EXPECT_EQ(b.at(0.999).scale, Vec3d(1));
    EXPECT_EQ(b.at(1).scale, Vec3d(2));
}

TEST(Animation, CubicSplinesFollowTheirTangents) {
    // f(t) = t³ over two seconds: value 0 and 8, slope 0 and 12.
    Builder b;
    b.animate_node("translation", b.add({0, 2}),
                   b.add({9, 9, 9, 0, 0, 1, 0, 0, 0, 12, 0, 0, 8, 0, 1, 9, 9, 9}, 3),
                   Interpolation::cubic_spline);
    for (const double t : {0.0, 0.5, 1.0, 1.75, 2.0}) {
        EXPECT_NEAR(b.at(t).translation.x, t * t * t, 1e-12);
        EXPECT_NEAR(b.at(t).translation.z, 1, 1e-12);
    }
    EXPECT_EQ(b.at(-1).translation.x, 0);
    EXPECT_EQ(b.at(3).translation.x, 8);
}

TEST(Animation, CubicSplinesNeedTwoKeyframes) {
    Builder b;
    b.animate_node("translation", b.add({0}), b.add(std::vector<float>(9), 3),
                   Interpolation::cubic_spline);
    expect_error([&] { b.at(0); },
                 "animations[0].samplers[0].input: has one keyframe, but a cubic spline needs two");
}

TEST(Animation, RotationsTakeTheShorterArcAtConstantSpeed) {
    const float half = std::sqrt(0.5f);
    Builder b;
    // 0° and 90° about z, the latter negated so that naive interpolation would take the long arc.
    b.animate_node("rotation", b.add({0, 3}), b.add({0, 0, 0, 1, 0, 0, -half, -half}, 4));
    const auto q = b.at(1).rotation;
    EXPECT_NEAR(q[2], std::sin(pi / 12), 1e-7);
    EXPECT_NEAR(q[3], std::cos(pi / 12), 1e-7);

    Builder same;
    same.animate_node("rotation", same.add({0, 1}), same.add({0, 0, 0, 2, 0, 0, 0, 2}, 4));
    EXPECT_EQ(same.at(0.5).rotation, (std::array<double, 4>{0, 0, 0, 1}));
}

TEST(Animation, NormalisedIntegersAreRotationsAndWeights) {
    Builder b;
    const std::vector<int16_t> turns{0, 0, 0, 32767, 0, 32767, 0, 0};
    b.animate_node("rotation", b.add({0, 1}), b.add(turns, ComponentType::int16, 4, 1, true));
    EXPECT_EQ(b.at(1).rotation, (std::array<double, 4>{0, 1, 0, 0}));

    Builder raw;
    raw.animate_node("rotation", raw.add({0, 1}), raw.add(turns, ComponentType::int16, 4));
    expect_error([&] { raw.at(0); },
                 "animations[0].samplers[0].output: does not hold floats or normalised integers");
    Builder moved;
    moved.animate_node("translation", moved.add({0, 1}),
                       moved.add(std::vector<int16_t>(6), ComponentType::int16, 3, 1, true));
    expect_error([&] { moved.at(0); }, "animations[0].samplers[0].output: does not hold floats");
}

TEST(Animation, WeightsComeInGroupsOfTheTargets) {
    Builder b;
    b.document.nodes.emplace_back().mesh = 0;
    b.document.meshes.emplace_back().primitives.emplace_back().targets.resize(2);
    const uint32_t times = b.add({0, 1});
    b.animate_node("weights", times, b.add({0, 1, 1, 0.5f}));
    EXPECT_EQ(b.at(0.5).weights, (std::vector<float>{0.5f, 0.75f}));
    b.animate_node("weights", times, b.add({0, 1, 1}));
    expect_error([&] { b.at(0); }, "animations[1].samplers[0].output: has 3 elements, not 4");
    b.document.meshes[0].primitives.clear();
    expect_error([&] { b.at(0); },
                 "animations[0].channels[0].target.path: nodes[0] has no morph targets");
}

TEST(Animation, IsSelectedByNameBeforeIndexOrIsAll) {
    Builder b;
    const uint32_t time = b.add({0});
    b.animate_node("translation", time, b.add({1, 0, 0}, 3));
    b.animate_node("translation", time, b.add({2, 0, 0}, 3));
    b.animate_node("scale", time, b.add({3, 3, 3}, 3));
    b.document.animations[0].name = "2";
    b.document.animations[1].name = "walk";
    EXPECT_EQ(b.at(0, "2").translation.x, 1);
    EXPECT_EQ(b.at(0, "walk").translation.x, 2);
    EXPECT_EQ(b.at(0, "0").translation.x, 1);
    EXPECT_EQ(b.document.nodes[0].scale.x, 1);
    EXPECT_EQ(b.at(0).translation.x, 2);
    EXPECT_EQ(b.document.nodes[0].scale.x, 3);
    for (const std::string wanted : {"run", "3"})
        expect_error([&] { b.at(0, wanted); }, "animations: there is no animation \"" + wanted +
                                                   "\"; the file has 0 \"2\", 1 \"walk\", 2 \"\"");
}

TEST(Animation, ErrorsNameTheirPlace) {
    const auto with_times = [](const std::vector<float>& times) {
        Builder b;
        b.animate_node("translation", b.add(times), b.add(std::vector<float>(6), 3));
        b.at(0);
    };
    const std::string input = "animations[0].samplers[0].input: ";
    expect_error([&] { with_times({}); }, input + "has no keyframes");
    expect_error([&] { with_times({1, 1}); }, input + "keyframes 0 and 1 have the same time, 1");
    expect_error([&] { with_times({0, NAN}); }, input + "times do not ascend at keyframe 1");
    expect_error([&] { with_times({1, 0}); }, input + "times do not ascend at keyframe 1");
    expect_error([&] { with_times({-1, 0}); }, input + "the first time is -1");
    expect_error(
        [&] {
            with_times({0, 1, 2});
        },
        "animations[0].samplers[0].output: has 2 elements, not 3");
    Builder b;
    b.document.nodes.emplace_back().has_matrix = true;
    b.animate_node("translation", b.add({0}), b.add({0, 0, 0}, 3));
    expect_error([&] { b.at(0); }, "animations[0].channels[0].target.node: nodes[0] has a matrix");
    b.document.nodes[0].has_matrix = false;
    b.document.animations[0].channels.push_back(b.document.animations[0].channels[0]);
    expect_error([&] { b.at(0); },
                 "animations[0].channels[1].target: another channel has the same target");
    b.document.animations[0].channels.resize(1);
    b.document.animations[0].channels[0].path = "rotation";
    expect_error([&] { b.at(0); }, "animations[0].samplers[0].output: has 3 components, not 4");
    b.document.animations[0].channels[0] = {0, none, "pointer"};  // an extension's
    EXPECT_EQ(b.at(0).translation, Vec3d(0));
}

/// A triangle with two morph targets and, in set 0 and 1, influences of four joints.
struct Puppet : Builder {
    GltfPrimitive primitive;
    Mesh mesh;

    Puppet() {
        mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        mesh.normals.assign(3, {0, 0, 1});
        mesh.tangents.assign(3, {1, 0, 0, 1});
    }
    void influence(int set, const std::vector<uint8_t>& joints, const std::vector<float>& weights) {
        primitive.attributes["JOINTS_" + std::to_string(set)] =
            add(joints, ComponentType::uint8, 4);
        primitive.attributes["WEIGHTS_" + std::to_string(set)] = add(weights, 4);
    }
};

TEST(Morph, TargetsAreAddedByWeight) {
    Puppet p;
    p.primitive.targets.resize(2);
    p.primitive.targets[0]["POSITION"] = p.add({0, 0, 1, 0, 0, 2, 0, 0, 3}, 3);
    p.primitive.targets[0]["NORMAL"] = p.add({1, 0, 0, 1, 0, 0, 1, 0, 0}, 3);
    p.primitive.targets[1]["POSITION"] =
        p.add(std::vector<int8_t>{127, 0, 0, 0, 0, 0, 0, 0, -127}, ComponentType::int8, 3, 1, true);
    p.primitive.targets[1]["TANGENT"] = p.add({0, 1, 0, 0, 0, 0, 0, 0, 0}, 3);
    Mesh rest = p.mesh;
    morph(p.document, p.primitive, {}, "here", rest);
    EXPECT_EQ(rest.positions, p.mesh.positions);
    const std::vector<float> weights{0.5f, 2};
    morph(p.document, p.primitive, weights, "here", p.mesh);
    EXPECT_EQ(p.mesh.positions[0], Vec3(2, 0, 0.5f));
    EXPECT_EQ(p.mesh.positions[2], Vec3(0, 1, -0.5f));
    EXPECT_NEAR(p.mesh.normals[0].x, 0.5f / std::sqrt(1.25f), 1e-6f);
    EXPECT_NEAR(p.mesh.normals[0].length(), 1, 1e-6f);
    EXPECT_NEAR(p.mesh.tangents[0].y, 2 / std::sqrt(5.0f), 1e-6f);
    EXPECT_EQ(p.mesh.tangents[0].w, 1);
}

TEST(Morph, ErrorsNameTheirPlace) {
    Puppet p;
    p.primitive.targets.resize(1);
    p.primitive.targets[0]["POSITION"] = p.add({0, 0, 1}, 3);
    const std::vector<float> one{1}, two{1, 1};
    expect_error([&] { morph(p.document, p.primitive, one, "here", p.mesh); },
                 "here.targets[0].POSITION: has 1 elements for 3 vertices");
    expect_error([&] { morph(p.document, p.primitive, two, "here", p.mesh); },
                 "here.targets: 1 targets but 2 weights");
}

TEST(Skin, JointsCarryVerticesToWorldSpace) {
    Puppet p;
    p.document.skins.emplace_back().joints = {1, 0};
    p.document.skins[0].inverse_binds = {Mat4().setTranslation(Vec3(-1, 0, 0)), Mat4()};
    const Mat4d turned = Mat4d().setEulerAngles(Vec3d(0, 0, double(pi) / 2));
    const std::vector<Mat4d> world{Mat4d().setTranslation(Vec3d(0, 0, 5)), turned};
    const auto joints = joint_matrices(p.document.skins[0], world);
    // Vertex 1 follows node 1 (rotated by 90° about its bind position), vertex 2 node 0 by two
    // sets.
    p.influence(0, {1, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0});
    p.influence(1, {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0}, {0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0});
    p.mesh.positions[1] = {2, 0, 0};
    skin(p.document, p.primitive, joints, "here", p.mesh);
    EXPECT_NEAR((p.mesh.positions[0] - Vec3(0, 0, 5)).length(), 0, 1e-6f);
    EXPECT_NEAR((p.mesh.positions[1] - Vec3(0, 1, 0)).length(), 0, 1e-6f);
    EXPECT_NEAR((p.mesh.positions[2] - Vec3(0, 1, 5)).length(), 0, 1e-6f);
    EXPECT_NEAR((p.mesh.normals[1] - Vec3(0, 0, 1)).length(), 0, 1e-6f);
    EXPECT_NEAR(p.mesh.tangents[1].y, 1, 1e-6f);
}

TEST(Skin, MirroringAndFlatteningJointsKeepNormalsUpright) {
    Puppet p;
    p.influence(0, {0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0});
    const std::vector<Mat4d> joints{Mat4d().setScale(Vec3d(-2, 1, 1)),
                                    Mat4d().setScale(Vec3d(1, 1, 0))};
    skin(p.document, p.primitive, joints, "here", p.mesh);
    EXPECT_EQ(p.mesh.tangents[0], Vec4(-1, 0, 0, -1));
    EXPECT_EQ(p.mesh.normals[0], Vec3(0, 0, 1));
    EXPECT_EQ(p.mesh.normals[1], Vec3(0, 0, 1));
    EXPECT_EQ(p.mesh.positions[2], Vec3(0, 1, 0));  // no weights: the first joint
}

TEST(Skin, MirroringJointsKeepFrontFacesCounterClockwise) {
    Puppet p;
    p.influence(0, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
    for (const double scale : {1.0, -1.0}) {
        Mesh mesh = p.mesh;
        mesh.triangles = {{0, 1, 2}};
        const std::vector<Mat4d> joints{Mat4d().setScale(Vec3d(scale, 1, 1))};
        skin(p.document, p.primitive, joints, "here", mesh);
        const auto [a, b, c] = mesh.triangles[0];
        const Vec3 face =
            cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
        EXPECT_GT(dot(face, mesh.normals[a]), 0) << scale;
    }
}

TEST(Skin, ErrorsNameTheirPlace) {
    Puppet p;
    const std::vector<Mat4d> joints(2);
    const auto skinned = [&] { skin(p.document, p.primitive, joints, "here", p.mesh); };
    expect_error(skinned, "here.attributes.JOINTS_0: is missing");
    p.influence(0, {0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0}, std::vector<float>(12, 1));
    expect_error(skinned, "here.attributes.JOINTS_0: joint 2 is out of range: the skin has 2");
    p.influence(0, std::vector<uint8_t>(8), std::vector<float>(12));
    expect_error(skinned,
                 "here.attributes.JOINTS_0: does not have four joints for each of 3 vertices");
    p.influence(0, std::vector<uint8_t>(12), std::vector<float>(8));
    expect_error(skinned, "here.attributes.WEIGHTS_0: has 2 elements for 3 vertices");
    p.influence(0, std::vector<uint8_t>(12), std::vector<float>(12));
    p.primitive.attributes["JOINTS_1"] = p.primitive.attributes["JOINTS_0"];
    expect_error(skinned, "here.attributes.WEIGHTS_1: is missing");

    const std::vector<Mat4d> world(1);
    p.document.skins.emplace_back();
    expect_error([&] { check_skins(p.document); }, "skins[0].joints: is empty");
    p.document.skins[0].joints = {0, 0};
    p.document.skins[0].inverse_bind_matrices = p.add(std::vector<float>(16), 4, 4);
    expect_error([&] { check_skins(p.document); },
                 "skins[0].inverseBindMatrices: has 1 matrices for 2 joints");
}

}  // namespace
}  // namespace sightline
