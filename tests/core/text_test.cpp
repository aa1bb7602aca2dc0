#include "core/text.h"
#include "core/error.h"

#include <gtest/gtest.h>

#include <vector>

namespace sightline {
namespace {

TEST(Text, PlainTextOfAnyScriptIsUnchanged) {
    for (const char* text : {"", "a b\\n'\"", "ünï ❤ 日本 🙂", "\xc2\xa0\xef\xbf\xbd"})
        EXPECT_EQ(printable(text), text);
}

TEST(Text, LineBreaksAndTerminalControlsAreEscaped) {
    EXPECT_EQ(printable("a\nb\tc\rd"), "a\\nb\\tc\\x0dd");
    EXPECT_EQ(printable("\x1b[2J\x7f"), "\\x1b[2J\\x7f");
    EXPECT_EQ(printable(std::string_view("\0", 1)), "\\x00");
    EXPECT_EQ(printable("\u0085"), "\\xc2\\x85");
    EXPECT_EQ(printable("\u2028\u202e\u2066"), "\\xe2\\x80\\xa8\\xe2\\x80\\xae\\xe2\\x81\\xa6");
}

TEST(Text, BytesThatAreNotUtf8AreEscaped) {
    EXPECT_EQ(printable("a\xff"
                        "b"),
              "a\\xffb");
    EXPECT_EQ(printable("\xc3"), "\\xc3");  // cut off
    EXPECT_EQ(printable("\xc3("), "\\xc3(");
    EXPECT_EQ(printable("\xc0\xaf"), "\\xc0\\xaf");           // longer than need be
    EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");  // half of a pair
    EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
}

TEST(Text, AnErrorIsAlwaysOneLine) {
    const std::string once = Error("a\nb: \x1b[31m: bad").what();
    EXPECT_EQ(once, "a\\nb: \\x1b[31m: bad");
    EXPECT_EQ(Error(once).what(), once);
}

TEST(Text, ShellWordsAreQuotedOnlyIfNeeded) {
    EXPECT_EQ(shell_quoted("a/b-1.gltf"), "a/b-1.gltf");
    EXPECT_EQ(shell_quoted(""), "''");
    EXPECT_EQ(shell_quoted("it's"), "'it'\\''s'");
    EXPECT_EQ(shell_quoted("\xff"), "$'\\xff'");
}

TEST(Text, DurationsHaveHoursOnlyIfNeeded) {
    EXPECT_EQ(clock_text(6.6), "0:07");
    EXPECT_EQ(clock_text(3599), "59:59");
    EXPECT_EQ(clock_text(3723), "1:02:03");
}

TEST(Choices, AreFoundByNameBeforeIndex) {
    const std::vector<std::string> names = {"1", "walk", ""};
    EXPECT_EQ(find_choice(names, "walk"), 1u);
    EXPECT_EQ(find_choice(names, "1"), 0u);
    EXPECT_EQ(find_choice(names, "2"), 2u);
    EXPECT_EQ(find_choice(names, ""), 2u);
    for (const char* none : {"3", "-1", "1.0", " 1", "99999999999999999999", "Walk"})
        EXPECT_EQ(find_choice(names, none), std::nullopt) << none;
}

TEST(Choices, AreListedUpToTwenty) {
    std::vector<std::string> names;
    EXPECT_EQ(list_choices(names), "none");
    names = {"idle", ""};
    EXPECT_EQ(list_choices(names), "0 \"idle\", 1 \"\"");
    names.resize(21, "x");
    EXPECT_TRUE(list_choices(names).ends_with("19 \"x\" and 1 more"));
}

}  // namespace
}  // namespace sightline
