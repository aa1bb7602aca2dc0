#include "batch/plan.h"

#include "batch/inputs.h"
#include "batch/manifest.h"
#include "core/error.h"
#include "core/text.h"
#include "support/messages.h"
#include "support/plans.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>

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

std::vector<AssetRequest> find(const std::string& input) {
    InputSearch search;
    return find_assets(input, {}, search);
}

std::vector<std::string> names_of(const std::vector<AssetRequest>& requests) {
    std::vector<std::string> names;
    for (const AssetRequest& request : requests) names.push_back(request.name);
    return names;
}

TEST(BatchInputs, FoldersAreSearchedRecursivelyAndNamesKeepSubfolders) {
    const Folder folder;
    folder.add("b.GLTF"), folder.add("x/y/a.glb"), folder.add("x/a.bin");
    EXPECT_THAT(names_of(find(folder.path())), ElementsAre("b", "x/y/a"));
}

TEST(BatchInputs, NamesFromAPatternBeginAtItsFirstWildcard) {
    const Folder folder;
    folder.add("x/a.glb"), folder.add("y/a.glb"), folder.add("y/b.txt");
    EXPECT_THAT(names_of(find(folder.path("*/a.*"))), ElementsAre("x/a", "y/a"));
    EXPECT_THAT(names_of(find(folder.path("x/*.glb"))), ElementsAre("a"));
}

TEST(BatchInputs, FileNamesMayContainAnyCharacters) {
    const Folder folder;
    for (const std::string name : {"[a]*", "-o", "two words", "line\nbreak", "ünïcode"}) {
        const auto requests = find(folder.add(name + ".glb"));
        ASSERT_EQ(requests.size(), 1u);
        EXPECT_EQ(requests[0].name, name);
    }
}

std::vector<std::string> reasons_of(const InputSearch& search) {
    std::vector<std::string> reasons;
    for (const PassedOver& p : search.passed_over)
        reasons.push_back(fs::path(p.path).filename().string() + " " + p.reason);
    return reasons;
}

TEST(BatchInputs, LinksOutOfTheFolderAreFollowedOnlyIfWanted) {
    const Folder folder;
    folder.add("in/a.glb"), folder.add("out/b.glb"), folder.add("out/sub/c.glb");
    fs::create_symlink("../out/b.glb", folder.path("in/file.glb"));
    fs::create_directory_symlink("../out/sub", folder.path("in/sub"));
    fs::create_symlink("a.glb", folder.path("in/inside.glb"));
    fs::create_directory_symlink("..", folder.path("in/up"));
    InputSearch search, following{true, {}, ""};
    EXPECT_THAT(names_of(find_assets(folder.path("in"), {}, search)), ElementsAre("a", "inside"));
    EXPECT_THAT(reasons_of(search),
                ElementsAre(HasSubstr("file.glb is a link out of"), HasSubstr("sub is a link out"),
                            HasSubstr("up is a link out of")));
    EXPECT_THAT(names_of(find_assets(folder.path("in"), {}, following)),
                ElementsAre("a", "file", "inside", "sub/c", "up/out/b"));
    EXPECT_THAT(reasons_of(following), ElementsAre());
}

TEST(BatchInputs, PatternsFollowTheSameRuleOfLinks) {
    const Folder folder;
    folder.add("in/a.glb"), folder.add("out/b.glb");
    fs::create_symlink("../out/b.glb", folder.path("in/b.glb"));
    InputSearch search;
    EXPECT_THAT(names_of(find_assets(folder.path("in/*.glb"), {}, search)), ElementsAre("a"));
    EXPECT_THAT(reasons_of(search), ElementsAre(HasSubstr("b.glb is a link out of")));
}

TEST(BatchInputs, WhatIsPassedOverIsListed) {
    const Folder folder;
    folder.add("a.glb"), folder.add("chair.obj"), folder.add("readme.txt"), folder.add("x/b.bin");
    fs::create_symlink("nowhere", folder.path("dangling.glb"));
    ASSERT_EQ(mkfifo(folder.path("pipe.glb").c_str(), 0600), 0);
    InputSearch search;
    EXPECT_THAT(names_of(find_assets(folder.path(), {}, search)), ElementsAre("a"));
    EXPECT_THAT(reasons_of(search),
                ElementsAre(HasSubstr("chair.obj is Wavefront OBJ; only glTF is read"),
                            HasSubstr("dangling.glb is a link to something that does not exist"),
                            HasSubstr("pipe.glb is not a regular file")));
}

TEST(BatchInputs, ALinkInTheFolderMustBeRelativeAsInAssets) {
    const Folder folder;
    folder.add("in/a.glb");
    fs::create_symlink(folder.path("in/a.glb"), folder.path("in/b.glb"));
    InputSearch search;
    EXPECT_THAT(names_of(find_assets(folder.path("in"), {}, search)), ElementsAre("a"));
    EXPECT_THAT(reasons_of(search), ElementsAre(HasSubstr("b.glb is a link out of")));
}

TEST(BatchInputs, AFileThatDoesNotExistIsATaskThatFails) {
    const Folder folder;
    folder.add("a.glb");
    InputSearch search;
    auto requests = find_assets(folder.path("missing.glb"), {}, search);
    EXPECT_EQ(requests.at(0).name, "missing");
    EXPECT_EQ(search.problem, folder.path("missing.glb") + ": no such file or folder");
    std::ranges::move(find_assets(folder.path("a.glb"), {}, search), std::back_inserter(requests));
    check_that_one_exists(requests, search);
}

TEST(BatchInputs, FoldersAndPatternsWithoutAssetsArePassedOver) {
    const Folder folder;
    fs::create_directory(folder.path("none"));
    InputSearch search;
    EXPECT_TRUE(find_assets(folder.path("none"), {}, search).empty());
    EXPECT_TRUE(find_assets(folder.path("*.glb"), {}, search).empty());
    EXPECT_THAT(reasons_of(search),
                ElementsAre("none no .gltf or .glb file in this folder",
                            "*.glb no .gltf or .glb file matches this pattern"));
}

TEST(BatchInputs, NoAssetAtAllIsAnErrorThatNamesTheFirstInput) {
    const Folder folder;
    for (const char* name : {"", "missing.glb", "*.glb"}) {
        InputSearch search;
        const auto requests = find_assets(folder.path(name), {}, search);
        find_assets("other.glb", {}, search);
        EXPECT_THAT(message_of([&] { check_that_one_exists(requests, search); }),
                    testing::StartsWith(folder.path(name) + ": no "));
    }
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
    EXPECT_EQ(tasks[0].settings,
              (Settings{{"camera", "front"}, {"frame-for", "9..10@4"}, {"time", "2.25"}}));
}

TEST(BatchPlan, ATurntableStartsAtTheGivenOrbit) {
    RenderSpec spec;
    spec.turntable = {4, std::nullopt};
    spec.settings["orbit"] = "10";
    std::vector<std::string> orbits;
    for (const Task& task : make_tasks({request("a", spec)}))
        orbits.push_back(task.settings.at("orbit"));
    EXPECT_THAT(orbits, ElementsAre("10", "100", "190", "280"));
}

TEST(BatchPlan, ATurntableMayHaveAViewOfItsOwn) {
    RenderSpec spec;
    spec.turntable = {2, ViewAngles{45, 20}};
    const auto tasks = make_tasks({request("a", spec)});
    ASSERT_EQ(tasks.size(), 2u);
    EXPECT_EQ(tasks[0].settings, (Settings{{"camera", "45/20"}, {"orbit", "0"}}));
    EXPECT_EQ(tasks[1].settings, (Settings{{"camera", "45/20"}, {"orbit", "180"}}));
    spec.settings["camera"] = "front";
    EXPECT_THROW(check_names(spec), NameError);
    spec.settings.clear();
    spec.views = {camera_view("front")};
    EXPECT_THROW(check_names(spec), NameError);
}

TEST(BatchPlan, AllAssetsAreFramedAlikeUnlessTheirCamerasAreAskedFor) {
    RenderSpec spec;
    EXPECT_EQ(make_tasks({request("a", spec)})[0].settings, (Settings{{"camera", "fit"}}));
    spec.settings["look-from"] = "1,2,3";
    EXPECT_EQ(make_tasks({request("a", spec)})[0].settings, (Settings{{"look-from", "1,2,3"}}));
    spec.settings.clear();
    spec.use_file_cameras = true;
    EXPECT_EQ(make_tasks({request("a", spec)})[0].settings, Settings());
    spec.frames = parse_frames("0..1", 2);
    spec.settings["frame-each"] = "";
    EXPECT_FALSE(make_tasks({request("a", spec)})[0].settings.contains("frame-for"));
}

TEST(BatchPlan, ViewsByAnglesHaveNamesForFiles) {
    RenderSpec spec;
    spec.views = make_views(std::vector<std::string>{"front", "-45/20", "ring:2@10"});
    EXPECT_THAT(
        outputs_of(make_tasks({request("a", spec)})),
        ElementsAre("a_front.png", "a_az315_el20.png", "a_az000_el10.png", "a_az180_el10.png"));
    EXPECT_EQ(make_tasks({request("a", spec)})[1].settings, (Settings{{"camera", "315/20"}}));
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

TEST(BatchPlan, InvalidTemplatesAreErrorsOfNames) {
    for (const char* bad : {"{assets}", "{asset", "{frame:x}", "{stem:3}", "{asset}{"}) {
        RenderSpec spec;
        spec.name = bad;
        EXPECT_THROW(check_names(spec), NameError) << bad;
        EXPECT_THROW(make_tasks({request("a", spec)}), NameError) << bad;
    }
}

TEST(BatchPlan, ATemplateMustTellViewsAndFramesApart) {
    RenderSpec frames, views, twice, alike;
    frames.name = "helmet_%04d";
    frames.turntable = {3, std::nullopt};
    views.name = "{stem}";
    views.views = {camera_view("front"), camera_view("left")};
    twice.views = {camera_view("front"), camera_view("front")};
    alike.views = {camera_view("a/b"), camera_view("a_b")};
    const auto refusal = [](const RenderSpec& spec) {
        return message_of([&] { check_names(spec); });
    };
    EXPECT_THAT(refusal(frames), HasSubstr("add {frame:04}, as in 'helmet_{frame:04}'"));
    EXPECT_THAT(refusal(views), HasSubstr("add {view}, as in '{stem}_{view}'"));
    EXPECT_THAT(refusal(twice), HasSubstr("the view 'front' is given twice"));
    EXPECT_THAT(refusal(alike), HasSubstr("'a/b' and 'a_b'"));
    views.views.pop_back();
    EXPECT_EQ(refusal(views), "");
}

// The outputs of assets, all with the same template.
std::vector<std::string> outputs_of_assets(const std::vector<std::string>& assets,
                                           const KnownNames& known = {},
                                           const std::string& name_template = "") {
    std::vector<AssetRequest> requests;
    for (const std::string& asset : assets) {
        AssetRequest& request = requests.emplace_back();
        request.asset = asset;
        request.name = fs::path(asset).stem();
        request.spec.name = name_template;
    }
    return outputs_of(make_tasks(requests, known));
}

TEST(BatchPlan, FoldersTellAssetsOfOneNameApart) {
    EXPECT_THAT(outputs_of_assets({"/x/a/Box.glb", "/x/b/Box.glb", "/x/b/Lamp.glb"}),
                ElementsAre("a/Box.png", "b/Box.png", "Lamp.png"));
    EXPECT_THAT(outputs_of_assets({"/x/1/c/Box.glb", "/x/2/c/Box.glb"}),
                ElementsAre("1/c/Box.png", "2/c/Box.png"));
}

TEST(BatchPlan, TheLaterOfTwoAssetsInAFolderKeepsItsExtension) {
    EXPECT_THAT(outputs_of_assets({"/Box.glb", "/Box.gltf"}),
                ElementsAre("Box.png", "Box.gltf.png"));
    EXPECT_THAT(outputs_of_assets({"/x/a/Box.glb", "/x/a/Box.gltf", "/x/b/Box.gltf"}),
                ElementsAre("a/Box.png", "a/Box.gltf.png", "b/Box.png"));
}

TEST(BatchPlan, AnAssetWhoseOwnNameIsTakenByNoOtherGetsIt) {
    EXPECT_THAT(outputs_of_assets({"/Box.glb", "/Box.gltf", "/Box.gltf.glb"}),
                ElementsAre("Box.png", "Box_2.png", "Box.gltf.png"));
}

TEST(BatchPlan, ANameThatTheJournalKnowsStays) {
    const KnownNames gltf = {{"/Box.gltf", {"Box"}}};
    EXPECT_THAT(outputs_of_assets({"/Box.glb", "/Box.gltf"}, gltf),
                ElementsAre("Box.glb.png", "Box.png"));
    // Even if the other asset, or the reason for the longer name, is gone.
    EXPECT_THAT(outputs_of_assets({"/Box.glb"}, gltf), ElementsAre("Box.glb.png"));
    EXPECT_THAT(outputs_of_assets({"/a/Box.glb"}, {{"/a/Box.glb", {"a/Box"}}}),
                ElementsAre("a/Box.png"));
    EXPECT_THAT(outputs_of_assets({"/x/a/Box.glb", "/x/b/Box.glb", "/y/c/Box.glb"},
                                  {{"/x/a/Box.glb", {"a/Box"}}, {"/x/b/Box.glb", {"b/Box"}}}),
                ElementsAre("a/Box.png", "b/Box.png", "y/c/Box.png"));
    EXPECT_THAT(outputs_of_assets({"/x/a/Box.glb", "/x/b/Box.glb"}, {{"/x/b/Box.glb", {"Box"}}}),
                ElementsAre("a/Box.png", "Box.png"));
}

TEST(BatchPlan, ATemplateWithoutTheFolderLeavesAssetsApart) {
    EXPECT_THAT(outputs_of_assets({"/a/Box.glb", "/b/Box.glb", "/c/Box.glb"}, {}, "{stem}"),
                ElementsAre("Box.png", "Box.glb.png", "Box_2.png"));
    EXPECT_THAT(outputs_of_assets({"/Box.glb", "/Box.gltf"}, {}, "{stem}.{ext}"),
                ElementsAre("Box.glb.png", "Box.gltf.png"));
}

TEST(BatchPlan, ATemplateWithoutTheAssetIsForOneAsset) {
    EXPECT_THAT(outputs_of_assets({"/a/Box.glb"}, {}, "chair"), ElementsAre("chair.png"));
    const std::string message = message_of([] {
        outputs_of_assets({"/a/Box.glb", "/a/Lamp.glb"}, {}, "chair");
    });
    EXPECT_THAT(message, HasSubstr("/a/Lamp.glb"));
    EXPECT_THAT(message, HasSubstr("as in 'chair_{asset}'"));
}

TEST(BatchPlan, OneAssetWithTwoSettingsMakesTwoPictures) {
    std::vector<AssetRequest> requests(3, request("lamp"));
    requests[1].spec.settings["variant"] = "brass";
    const std::vector<std::string> repeated = remove_repeated(requests);
    EXPECT_THAT(repeated, ElementsAre("/assets/lamp.glb"));
    const auto tasks = make_tasks(requests);
    EXPECT_THAT(outputs_of(tasks), ElementsAre("lamp.png", "lamp_2.png"));
    EXPECT_EQ(tasks[1].settings.at("variant"), "brass");
}

TEST(BatchPlan, AThousandAssetsOfOneNameAreToldApart) {
    std::vector<std::string> assets;
    for (int i = 0; i < 1000; ++i) assets.push_back(fmt::format("/{}/Box.glb", i));
    const auto outputs = outputs_of_assets(assets, {}, "{stem}");
    EXPECT_EQ(std::set(outputs.begin(), outputs.end()).size(), 1000u);
}

TEST(BatchPlan, NamesThatLeaveTheFolderAreErrors) {
    for (const std::string& bad :
         {std::string("../a"), std::string("/a"), std::string("x/../../a"), std::string("a/"),
          std::string("."), std::string(".sightline/a"), std::string(1, '\0')}) {
        RenderSpec spec;
        spec.name = bad;
        EXPECT_THROW(make_tasks({request("a", spec)}), NameError) << bad;
    }
}

TEST(BatchPlan, NamesThatAreTooLongAreShortenedAndStayDifferent) {
    const std::string longest(251, 'a'), tail(200, 'b');
    std::string umlauts;
    for (int i = 0; i < 130; ++i) umlauts += "ü";
    EXPECT_EQ(make_tasks({request(longest)})[0].outputs[0], longest + ".png");
    const auto tasks = make_tasks({request(longest + "b"), request(longest + "c"), request(umlauts),
                                   request(tail + tail + "/x")});
    std::set<std::string> outputs;
    for (const Task& task : tasks) {
        outputs.insert(task.outputs[0]);
        EXPECT_TRUE(is_utf8(task.outputs[0]));
        for (const fs::path& part : fs::path(task.outputs[0]))
            EXPECT_LE(part.native().size(), 255u);
    }
    EXPECT_EQ(outputs.size(), 4u);
    EXPECT_EQ(fs::path(tasks[3].outputs[0]).filename(), "x.png");
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
    InputSearch search;
    return read_manifest(folder.add("manifest.json", text), defaults, options, search);
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
        {R"({"assets": [{"path": "a.glb", "smaples": 3}]})", "assets[0].smaples: is not an option"},
        {R"({"assets": [{"path": "a.glb", "size": {}}]})", "assets[0].size: "},
        {R"({"assets": [{"path": "a.glb", "views": {"x": {"sise": 1}}}]})",
         "assets[0].views.x.sise: is not an option"},
        {R"({"assets": [{"path": "a.glb", "frames": "3..1"}]})", "assets[0].frames: "},
        {R"({"assets": [{"path": "a.glb", "turntable": -1}]})",
         "assets[0].turntable: '-1' is not N"},
        {R"({"assets": [{"path": "a.glb", "turntable": "8@95"}]})",
         "assets[0].turntable: '8@95' has an elevation outside"},
        {R"({"assets": [{"path": "a.glb", "views": ["ring:0"]}]})",
         "assets[0].views: 'ring:0' is not ring:N"},
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
