// Runs `sightline diff` as a script would.
#include "image/write_image.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <nlohmann/json.hpp>

namespace sightline {
namespace {

struct Outcome {
    int code;
    std::string text;
};

Outcome diff(const std::string& arguments) {
    FILE* pipe = popen((SIGHTLINE_PROGRAM " diff " + arguments + " 2>&1").c_str(), "r");
    std::string text;
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
    return {WEXITSTATUS(pclose(pipe)), text};
}

std::string picture(const char* name, uint8_t grey, int width = 4) {
    Image image;
    image.width = width;
    image.height = 4;
    image.channels = 3;
    image.bytes.assign(static_cast<size_t>(width) * 12, grey);
    std::string path = (test_folder() / name).string();
    write_image(path, image);
    return path;
}

TEST(Diff, PrintsTheDistanceOfEachPictureFromTheReference) {
    const std::string black = picture("black.png", 0), grey = picture("grey.png", 51);
    const Outcome outcome = diff("--json " + black + " " + black + " " + grey);
    ASSERT_EQ(outcome.code, 0) << outcome.text;
    const auto list = nlohmann::json::parse(outcome.text);
    ASSERT_EQ(list.size(), 2u);
    EXPECT_EQ(list[0]["rmse"], 0);
    EXPECT_EQ(list[0]["flip_mean"], 0);
    EXPECT_NEAR(list[1]["rmse"].get<double>(), 0.2, 1e-6);
    EXPECT_NEAR(list[1]["max_abs"].get<double>(), 0.2, 1e-6);
    EXPECT_GT(list[1]["flip_mean"].get<double>(), 0.05);
}

TEST(Diff, RejectsOtherSizesMissingPicturesAndMissingArguments) {
    const std::string small = picture("small.png", 0), large = picture("large.png", 0, 8);
    EXPECT_EQ(diff(small + " " + large).code, 1);
    EXPECT_EQ(diff(small + " " + small + ".missing").code, 1);
    EXPECT_EQ(diff(small).code, 2);
}

}  // namespace
}  // namespace sightline
