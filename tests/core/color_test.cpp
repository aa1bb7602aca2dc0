#include "core/color.h"

#include "core/error.h"
#include "core/srgb.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

using testing::HasSubstr;

std::string refusal(const std::string& text) {
    try {
        parse_color(text);
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

TEST(Color, NamesCodesAndNumbersAreTheSameColours) {
    EXPECT_EQ(parse_color("white"), Vec3(1, 1, 1));
    EXPECT_EQ(parse_color("#fFf"), Vec3(1, 1, 1));
    EXPECT_EQ(parse_color("1,1,1"), Vec3(1, 1, 1));
    EXPECT_EQ(parse_color("0.25,0.5,0"), Vec3(0.25f, 0.5f, 0));
    EXPECT_EQ(parse_color("orange"), parse_color("#FFA500"));
    const Vec3 c = parse_color("#8040C0");
    EXPECT_NEAR(encode_srgb(c.x) * 255, 0x80, 1e-3f);
    EXPECT_NEAR(encode_srgb(c.y) * 255, 0x40, 1e-3f);
    EXPECT_NEAR(encode_srgb(c.z) * 255, 0xC0, 1e-3f);
}

TEST(Color, OtherWordsAreRefusedWithAHint) {
    EXPECT_THAT(refusal("255,255,255"), HasSubstr("white is 1,1,1 or white"));
    EXPECT_THAT(refusal("-0.1,0,0"), HasSubstr("outside 0 to 1"));
    EXPECT_THAT(refusal("whit"), HasSubstr("did you mean 'white'?"));
    for (const char* bad :
         {"", "#", "#12", "#12345", "#1234567", "#ggg", "1,2", "nan,0,0", "1,1,1,1"})
        EXPECT_THAT(refusal(bad), HasSubstr("is not a colour")) << bad;
}

}  // namespace
}  // namespace sightline
