#include "scene/view_names.h"

#include "core/error.h"
#include "support/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Vec3 row(const Mat4& m, int r) { return {m[r][0], m[r][1], m[r][2]}; }

// From the scene to the camera.
Vec3 direction_of(const std::string& view) { return row(view_rotation(*find_view(view)), 2); }

std::vector<std::string> names_of(const std::string& element) {
    std::vector<std::string> names;
    for (const NamedView& view : expand_view(element)) names.push_back(view.name);
    return names;
}

TEST(ViewNames, TheSidesAreExactAxesWithTheTopUpwards) {
    const std::tuple<const char*, Vec3, Vec3> sides[] = {
        {"front", {0, 0, 1}, {0, 1, 0}},  {"back", {0, 0, -1}, {0, 1, 0}},
        {"left", {-1, 0, 0}, {0, 1, 0}},  {"right", {1, 0, 0}, {0, 1, 0}},
        {"top", {0, 1, 0}, {0, 0, -1}},   {"bottom", {0, -1, 0}, {0, 0, 1}},
        {"90/0", {1, 0, 0}, {0, 1, 0}},   {"-90/0", {-1, 0, 0}, {0, 1, 0}},
        {"90/90", {0, 1, 0}, {-1, 0, 0}},
    };
    for (const auto& [view, direction, up] : sides) {
        EXPECT_EQ(direction_of(view), direction) << view;
        EXPECT_EQ(row(view_rotation(*find_view(view)), 1), up) << view;
    }
}

TEST(ViewNames, TheOtherViewsHaveTheirDefinedDirections) {
    const std::pair<const char*, Vec3> views[] = {
        {"fit", {0.6f, 0.35f, 0.8f}},
        {"iso", {1, 1, 1}},
        {"three-quarter", {1, std::sqrt(2.0f) * std::tan(pi / 9), 1}},
        {"three-quarter-left", {-1, std::sqrt(2.0f) * std::tan(pi / 9), 1}},
    };
    for (const auto& [view, direction] : views)
        EXPECT_LT((direction_of(view) - normalize(direction)).length(), 2e-7f) << view;
    EXPECT_EQ(find_view("three-quarter"), find_view("three-quarter-right"));
}

TEST(ViewNames, EveryRotationIsRigid) {
    for (const NamedView& view : expand_view("sphere:50")) {
        const Mat4 m = view_rotation(*find_view(view.camera));
        for (int r = 0; r < 3; ++r) EXPECT_NEAR(row(m, r).length(), 1, 1e-6f);
        EXPECT_LT((cross(row(m, 0), row(m, 1)) - row(m, 2)).length(), 1e-6f);
    }
}

TEST(ViewNames, OtherWordsMayNameCameras) {
    for (const char* word :
         {"", "Front", "lens", "3", "a/b", "1/2/3", "1/", "/1", "nan/0", "0x1/2"})
        EXPECT_FALSE(find_view(word)) << word;
    EXPECT_THAT(names_of("Lens 2"), ElementsAre("Lens 2"));
}

TEST(ViewNames, ARingBeginsInFrontOrWhereItIsToldTo) {
    EXPECT_THAT(names_of("ring:3"), ElementsAre("az000_el0", "az120_el0", "az240_el0"));
    EXPECT_THAT(names_of("ring:2@-12.5"), ElementsAre("az000_el-12.5", "az180_el-12.5"));
    EXPECT_THAT(names_of("ring:4@300/20"),
                ElementsAre("az300_el20", "az030_el20", "az120_el20", "az210_el20"));
    // Rounded in the name only.
    const NamedView view = expand_view("ring:7@20")[1];
    EXPECT_EQ(view.name, "az051.43_el20");
    EXPECT_DOUBLE_EQ(find_view(view.camera)->azimuth, 360.0 / 7);
}

TEST(ViewNames, ASphereIsEven) {
    constexpr int count = 200;
    std::vector<Vec3> directions;
    for (const NamedView& view : expand_view("sphere:200"))
        directions.push_back(direction_of(view.camera));
    ASSERT_EQ(directions.size(), size_t{count});
    Vec3 sum(0, 0, 0);
    for (const Vec3& d : directions) sum += d;
    EXPECT_LT(sum.length() / count, 0.01f);
    // Discs of this angle about the views would cover the sphere's area once: each view has a
    // neighbour within two such angles, and none within one.
    const float angle = std::acos(1 - 2.0f / count);
    for (const Vec3& a : directions) {
        float nearest = pi;
        for (const Vec3& b : directions)
            if (a != b) nearest = std::min(nearest, std::acos(std::clamp(dot(a, b), -1.0f, 1.0f)));
        EXPECT_GT(nearest, 1.0f * angle);
        EXPECT_LT(nearest, 2.0f * angle);
    }
    EXPECT_EQ(names_of("sphere:12")[0], "sphere12_01");
}

TEST(ViewNames, ListsAndAnglesOutOfRangeAreRefused) {
    const std::pair<const char*, const char*> bad[] = {
        {"3/4", "view three-quarter nor the angles 3.0/4"},
        {"10/91", "elevation outside -90 to 90"},
        {"400/0", "azimuth outside -360 to 360"},
        {"ring:", "'ring:' is not ring:N"},
        {"ring:0@20", "such as ring:8@20"},
        {"ring:8@", "is not ring:N"},
        {"ring:8@99", "'ring:8@99' has an elevation"},
        {"ring:8@x/1", "is not ring:N"},
        {"ring:1e9", "is not ring:N"},
        {"sphere:", "such as sphere:12"},
        {"sphere:0", "1 to 100000 views"},
        {"sphere:100001", "1 to 100000 views"},
        {"sphere:9999999999", "1 to 100000 views"},
    };
    for (const auto& [element, what] : bad)
        EXPECT_THAT(message_of([&, text = element] { expand_view(text); }), HasSubstr(what))
            << element;
    EXPECT_THAT(message_of([] { find_view("ring:8@20"); }), HasSubstr("only --views takes"));
}

}  // namespace
}  // namespace sightline
