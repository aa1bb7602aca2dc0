// Each scene of scenes/, rendered by the program, against a small reference picture that was
// inspected by eye. SIGHTLINE_UPDATE_REFERENCES=1 rewrites the references.
#include "core/files.h"
#include "image/image.h"
#include "support/test_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace sightline {
namespace {

namespace fs = std::filesystem;

const fs::path source = SIGHTLINE_SOURCE_DIR;

std::vector<std::string> scene_names() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(source / "scenes"))
        if (entry.path().extension() == ".gltf") names.push_back(entry.path().stem());
    std::sort(names.begin(), names.end());
    return names;
}

/// The options that the scene file gives for its picture.
std::string options_of(const fs::path& scene) {
    const auto file = read_file(scene, 1 << 24);
    const auto* text = reinterpret_cast<const char*>(file.data());
    return nlohmann::json::parse(text, text + file.size()).at("asset").at("extras").at("options");
}

struct Difference {
    double mean = 0;     ///< of all channels, in steps of 1/255
    double outside = 0;  ///< share of the values that differ by more than 8 steps
};

Difference difference(const Image& a, const Image& b) {
    Difference result;
    for (size_t i = 0; i < a.bytes.size(); ++i) {
        const int steps = std::abs(a.bytes[i] - b.bytes[i]);
        result.mean += steps;
        result.outside += steps > 8;
    }
    result.mean /= double(a.bytes.size());
    result.outside /= double(a.bytes.size());
    return result;
}

class ScenePicture : public testing::TestWithParam<std::string> {};

// The same instruction set gives the same bits. Another rounds differently, which changes a few
// samples at edges; hence the fraction of values that may differ.
TEST_P(ScenePicture, IsItsReference) {
    const fs::path scene = source / "scenes" / (GetParam() + ".gltf");
    const fs::path reference = source / "tests/reference" / (GetParam() + ".png");
    const bool update = std::getenv("SIGHTLINE_UPDATE_REFERENCES") != nullptr;
    const fs::path picture = update ? reference : test_folder() / "picture.png";
    const std::string command =
        fmt::format("\"{}\" render \"{}\" {} --quiet --size 160x120 -o \"{}\"", SIGHTLINE_PROGRAM,
                    scene.string(), options_of(scene), picture.string());
    ASSERT_EQ(std::system(command.c_str()), 0) << command;

    const Image is = read_image(picture), should = read_image(reference);
    ASSERT_EQ(is.width, 160);
    ASSERT_EQ(is.height, 120);
    ASSERT_EQ(is.channels, 3);
    ASSERT_EQ(should.bytes.size(), is.bytes.size());
    const Difference found = difference(is, should);
    EXPECT_LT(found.mean, 0.25);
    EXPECT_LT(found.outside, 0.005);
}

INSTANTIATE_TEST_SUITE_P(Scenes, ScenePicture, testing::ValuesIn(scene_names()),
                         [](const auto& test) { return test.param; });

TEST(Scenes, StateTheirPurpose) {
    for (const std::string& name : scene_names()) {
        const auto file = read_file(source / "scenes" / (name + ".gltf"), 1 << 24);
        const auto* text = reinterpret_cast<const char*>(file.data());
        const auto document = nlohmann::json::parse(text, text + file.size());
        EXPECT_FALSE(document.at("asset").at("extras").at("feature").get<std::string>().empty());
    }
}

}  // namespace
}  // namespace sightline
