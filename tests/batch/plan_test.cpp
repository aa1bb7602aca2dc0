#include "batch/plan.h"

#include "batch/inputs.h"
#include "batch/manifest.h"
#include "core/error.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

// A folder of small files, removed at the end.
class Folder {
  public:
    Folder() : path_(fs::path(testing::TempDir()) / fmt::format("batch_plan_{}", getpid())) {
        fs::remove_all(path_);
        fs::create_directories(path_);
    }
    ~Folder() { fs::remove_all(path_); }

    std::string add(const std::string& name, const std::string& text = "") const {
        fs::create_directories((path_ / name).parent_path());
        std::ofstream(path_ / name) << text;
        return path_ / name;
    }
    std::string path(const std::string& name = "") const { return path_ / name; }

  private:
    fs::path path_;
};

std::vector<std::string> names_of(const std::vector<AssetRequest>& requests) {
    std::vector<std::string> names;
    for (const AssetRequest& request : requests) names.push_back(request.name);
    return names;
}

std::vector<std::string> outputs_of(const std::vector<Task>& tasks) {
    std::vector<std::string> outputs;
    for (const Task& task : tasks)
        outputs.insert(outputs.end(), task.outputs.begin(), task.outputs.end());
    return outputs;
}

AssetRequest request(const std::string& name, const RenderSpec& spec = {}) {
    return {"/assets/" + name + ".glb", name, spec, 0};
}

std::string message_of(const auto& action) {
    try {
        action();
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

TEST(BatchInputs, FoldersAreSearchedRecursivelyAndNamesKeepSubfolders) {
    const Folder folder;
    folder.add("b.GLTF"), folder.add("x/y/a.glb"), folder.add("x/a.bin");
    EXPECT_THAT(names_of(find_assets(folder.path(), {})), ElementsAre("b", "x/y/a"));
}

TEST(BatchInputs, NamesFromAPatternBeginAtItsFirstWildcard) {
    const Folder folder;
    folder.add("x/a.glb"), folder.add("y/a.glb"), folder.add("y/b.txt");
    EXPECT_THAT(names_of(find_assets(folder.path("*/a.*"), {})), ElementsAre("x/a", "y/a"));
    EXPECT_THAT(names_of(find_assets(folder.path("x/*.glb"), {})), ElementsAre("a"));
}

TEST(BatchInputs, FileNamesMayContainAnyCharacters) {
    const Folder folder;
    for (const std::string name : {"[a]*", "-o", "two words", "line\nbreak", "ünïcode"}) {
        const auto requests = find_assets(folder.add(name + ".glb"), {});
        ASSERT_EQ(requests.size(), 1u);
        EXPECT_EQ(requests[0].name, name);
    }
}

TEST(BatchInputs, NoAssetIsAnError) {
    const Folder folder;
    EXPECT_THROW(find_assets(folder.path(), {}), Error);
    EXPECT_THROW(find_assets(folder.path("missing.glb"), {}), Error);
    EXPECT_THROW(find_assets(folder.path("*.glb"), {}), Error);
}

TEST(BatchPlan, OneAssetMakesOnePicture) {
    const auto tasks = make_tasks({request("a/b")});
    ASSERT_EQ(tasks.size(), 1u);
    EXPECT_THAT(tasks[0].outputs, ElementsAre("a/b.png"));
}

TEST(BatchPlan, CombinesViewsFramesAndFormats) {
    RenderSpec spec;
    spec.views = {camera_view("front"), camera_view("a/b")};
    spec.frames = parse_frames("9..10", 4);
    spec.formats = {"png", "exr"};
    const auto tasks = make_tasks({request("a", spec)});
    EXPECT_THAT(
        outputs_of(tasks),
        ElementsAre("a_front_0009.png", "a_front_0009.exr", "a_front_0010.png", "a_front_0010.exr",
                    "a_a_b_0009.png", "a_a_b_0009.exr", "a_a_b_0010.png", "a_a_b_0010.exr"));
    EXPECT_EQ(tasks[0].settings, (Settings{{"camera", "front"}, {"time", "2.25"}}));
}

TEST(BatchPlan, ATurntableStartsAtTheGivenOrbit) {
    RenderSpec spec;
    spec.turntable = 4;
    spec.settings["orbit"] = "10";
    std::vector<std::string> orbits;
    for (const Task& task : make_tasks({request("a", spec)}))
        orbits.push_back(task.settings.at("orbit"));
    EXPECT_THAT(orbits, ElementsAre("10", "100", "190", "280"));
}

TEST(BatchPlan, AllCamerasBecomeViewsByIndex) {
    AssetRequest o = request("a");
    o.spec.all_cameras = true;
    o.cameras = 2;
    EXPECT_THAT(outputs_of(make_tasks({o})), ElementsAre("a_camera0.png", "a_camera1.png"));
}

TEST(BatchPlan, NamesFollowTheTemplate) {
    RenderSpec spec;
    spec.name = "{variant}/{stem}.{ext}-{frame:04}-{frame}";
    spec.settings["variant"] = "dark oak";
    EXPECT_THAT(outputs_of(make_tasks({request("x/a", spec)})),
                ElementsAre("dark oak/a.glb-0000-0.png"));
}

TEST(BatchPlan, InvalidTemplatesAreErrors) {
    for (const char* bad : {"{assets}", "{asset", "{frame:x}", "{stem:3}", ""}) {
        RenderSpec spec;
        spec.name = std::string(bad) + "{asset";
        EXPECT_THROW(make_tasks({request("a", spec)}), Error) << bad;
    }
}

TEST(BatchPlan, AnErrorNamesBothAssetsOfACollision) {
    RenderSpec spec;
    spec.name = "{stem}";
    const std::string message = message_of([&] {
        make_tasks({request("x/a", spec), request("b"), request("y/a", spec)});
    });
    EXPECT_THAT(message, HasSubstr("a.png"));
    EXPECT_THAT(message, HasSubstr("/assets/x/a.glb"));
    EXPECT_THAT(message, HasSubstr("/assets/y/a.glb"));
}

TEST(BatchPlan, NamesThatLeaveTheFolderOrAreInvalidAreErrors) {
    for (const std::string& bad :
         {std::string("../a"), std::string("/a"), std::string("x/../../a"), std::string("a/"),
          std::string(".sightline/a"), std::string(252, 'a'), std::string(1, '\0')}) {
        RenderSpec spec;
        spec.name = bad;
        const bool is_folder = bad == "a/";  // "a/.png" is a valid name
        EXPECT_EQ(message_of([&] { make_tasks({request("a", spec)}); }).empty(), is_folder) << bad;
    }
    EXPECT_NO_THROW(make_tasks({request(std::string(251, 'a'))}));
}

TEST(BatchPlan, TheKeyDependsOnSettingsAndOutputs) {
    const Task task = make_tasks({request("a")})[0];
    Task other = task;
    other.settings["samples"] = "3";
    EXPECT_NE(task.key(), other.key());
    other = task;
    other.outputs[0] = "b.png";
    EXPECT_NE(task.key(), other.key());
    EXPECT_EQ(task.key(), make_tasks({request("a")})[0].key());
}

const std::set<std::string> options = {"samples", "size",   "error",         "env",
                                       "aov",     "camera", "allow-outside", "time"};

std::vector<AssetRequest> manifest(const Folder& folder, const std::string& text,
                                   const RenderSpec& defaults = {}) {
    return read_manifest(folder.add("manifest.json", text), defaults, options);
}

TEST(BatchManifest, AssetsOverrideTheManifestWhichOverridesTheCommandLine) {
    const Folder folder;
    folder.add("x/a.glb"), folder.add("b.glb");
    RenderSpec defaults;
    defaults.settings = {{"samples", "1"}, {"time", "7"}, {"allow-outside", ""}};
    const auto requests = manifest(folder, R"({"size": "8x8", "samples": 2, "env": "sky.hdr",
        "assets": [{"path": "x/a.glb", "samples": 3, "aov": ["depth", "uv"], "allow-outside": false},
                   {"path": "b.glb", "error": 0.5, "env": "none", "views": ["front", 1]}]})",
                                   defaults);
    ASSERT_EQ(requests.size(), 2u);
    EXPECT_EQ(requests[0].name, "a");
    EXPECT_EQ(requests[0].spec.settings, (Settings{{"size", "8x8"},
                                                   {"samples", "3"},
                                                   {"time", "7"},
                                                   {"aov", "depth,uv"},
                                                   {"env", folder.path("sky.hdr")}}));
    EXPECT_EQ(requests[1].spec.settings, (Settings{{"size", "8x8"},
                                                   {"error", "0.5"},
                                                   {"time", "7"},
                                                   {"env", "none"},
                                                   {"allow-outside", ""}}));
    ASSERT_EQ(requests[1].spec.views.size(), 2u);
    EXPECT_EQ(requests[1].spec.views[1].settings, (Settings{{"camera", "1"}}));
}

TEST(BatchManifest, ViewsMayHaveTheirOwnOptions) {
    const Folder folder;
    folder.add("a.glb");
    const auto requests = manifest(folder, R"({"turntable": 0, "name": "{view}", "format": "exr",
        "assets": [{"path": "a.glb", "views": {"near": {"camera": 2, "size": "9x9"}}}]})");
    const auto tasks = make_tasks(requests);
    ASSERT_EQ(tasks.size(), 1u);
    EXPECT_THAT(tasks[0].outputs, ElementsAre("near.exr"));
    EXPECT_EQ(tasks[0].settings, (Settings{{"camera", "2"}, {"size", "9x9"}}));
}

TEST(BatchManifest, ErrorsNameTheJsonPath) {
    const Folder folder;
    folder.add("a.glb");
    const std::pair<const char*, const char*> bad[] = {
        {"{", "invalid JSON"},
        {"[]", "must be an object"},
        {"{}", "assets: is missing"},
        {R"({"assets": [3]})", "assets[0]: must be an object"},
        {R"({"assets": [{}]})", "assets[0].path: is missing"},
        {R"({"assets": [{"path": "b.glb"}]})", "assets[0].path: "},
        {R"({"assets": [{"path": "a.glb", "smaples": 3}]})", "assets[0].smaples: is not an option"},
        {R"({"assets": [{"path": "a.glb", "size": {}}]})", "assets[0].size: "},
        {R"({"assets": [{"path": "a.glb", "views": {"x": {"sise": 1}}}]})",
         "assets[0].views.x.sise: is not an option"},
        {R"({"assets": [{"path": "a.glb", "frames": "3..1"}]})", "assets[0].frames: "},
        {R"({"assets": [{"path": "a.glb", "turntable": -1}]})", "assets[0].turntable: "},
        {R"({"fps": "x", "assets": []})", "fps: must be a number"},
    };
    for (const auto& [text, place] : bad)
        EXPECT_THAT(message_of([&, json = text] { manifest(folder, json); }), HasSubstr(place))
            << text;
}

TEST(BatchPlan, ParsesRangesOfFrames) {
    EXPECT_EQ(parse_frames("0..0", 1).last, 0);
    for (const char* bad : {"", "1", "1..", "2..1", "-1..1", "1..2x", "a..b"})
        EXPECT_THROW(parse_frames(bad, 24), Error) << bad;
    EXPECT_THROW(parse_frames("1..2", 0), Error);
}

}  // namespace
}  // namespace sightline
