#include "core/suggest.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sightline {
namespace {

const std::vector<std::string> words = {"render", "batch", "info", "turntable", "all"};

TEST(SimilarWord, IsAFewTypingErrorsAway) {
    EXPECT_EQ(similar_word("rendr", words), "render");    // one left out
    EXPECT_EQ(similar_word("renderr", words), "render");  // one too many
    EXPECT_EQ(similar_word("bitch", words), "batch");     // another one
    EXPECT_EQ(similar_word("rednre", words), "render");   // two swapped twice
    EXPECT_EQ(similar_word("INFO", words), "info");
}

TEST(SimilarWord, BeginsWithTheText) {
    EXPECT_EQ(similar_word("turn", words), "turntable");
    EXPECT_EQ(similar_word("t", words), "");
}

TEST(SimilarWord, IsTheNearest) {
    const std::vector<std::string> near = {"--sample", "--samples", "--simple"};
    EXPECT_EQ(similar_word("--samples2", near), "--samples");
}

TEST(SimilarWord, IsEmptyIfNothingIsSimilar) {
    EXPECT_EQ(similar_word("convert", words), "");
    EXPECT_EQ(similar_word("", words), "");
    EXPECT_EQ(similar_word("x", std::vector<std::string>{"y"}), "");
    EXPECT_EQ(similar_word(std::string(100000, 'r'), words), "");
    EXPECT_EQ(similar_word("render", {}), "");
}

TEST(DidYouMean, IsTheEndOfAMessage) {
    EXPECT_EQ(did_you_mean("rendr", words), "; did you mean 'render'?");
    EXPECT_EQ(did_you_mean("convert", words), "");
}

}  // namespace
}  // namespace sightline
