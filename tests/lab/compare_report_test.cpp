// The report of a comparison and the command that writes it.
#include "core/files.h"
#include "intersect/ray_file.h"
#include "scene/gltf/load.h"
#include "support/rays.h"
#include "support/scenes.h"
#include "support/test_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sys/wait.h>

#include <fstream>
#include <set>

namespace sightline {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

nlohmann::json results_in(const fs::path& folder) {
    return nlohmann::json::parse(text_of(folder / "results.json"));
}

const std::string table = SIGHTLINE_SOURCE_DIR "/scenes/table.gltf";

/// Runs the program with its output in the test's folder; returns the exit code.
int run_compare(const std::string& arguments) {
    const std::string command = std::string(SIGHTLINE_PROGRAM) + " compare " + arguments + " > '" +
                                (test_folder() / "out").string() + "' 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
}

std::string printed() { return text_of(test_folder() / "out"); }

/// Rays aimed at the vertices of a scene, some of which floating-point methods miss.
std::string write_vertex_rays() {
    const Scene scene = load_gltf(table);
    TestRandom random;
    std::vector<RecordedRay> rays;
    for (const Mesh& mesh : scene.meshes)
        for (int i = 0; i < 300; ++i)
            rays.push_back({aimed_ray(mesh, Aim::vertex, random, {0, 3, 3}), RayKind::camera});
    std::string path = (test_folder() / "rays").string();
    write_rays(path, rays, scene);
    return path;
}

TEST(CompareReport, ContainsTheDocumentedFields) {
    const std::string folder = (test_folder() / "report").string();
    ASSERT_EQ(run_compare(table + " --size 48x32 --rounds 1 --report " + folder), 0) << printed();
    const auto json = results_in(folder);
    for (const char* field : {"version", "command", "scene", "production", "rays", "methods",
                              "max_wrong_per_million", "invalid_rays", "worst"})
        EXPECT_TRUE(json.contains(field)) << field;
    EXPECT_EQ(json["rays"]["camera"], 1536);
    EXPECT_EQ(json["summary"].size(), 3u);
    EXPECT_EQ(json["rays_left"], 0);
    EXPECT_EQ(json["methods"][0]["name"], json["production"]);
    EXPECT_EQ(json["notes"].size(), 1u);  // the scene has shapes
    const auto wrapper = json["methods"][0]["kinds"]["camera"]["wrapper"];
    EXPECT_EQ(wrapper["library_call"], "rtcIntersect16");
    EXPECT_GT(wrapper["library_ns_per_ray"], 0);
    EXPECT_GT(wrapper["factor"], 0);
    EXPECT_NE(printed().find(fmt::format("{:.2f} × bare rtcIntersect16 (camera)",
                                         wrapper["factor"].get<double>())),
              std::string::npos)
        << printed();
    for (const auto& method : json["methods"]) {
        const auto& camera = method["kinds"]["camera"];
        for (const char* field : {"rays",
                                  "same",
                                  "tie",
                                  "near_tie",
                                  "missed",
                                  "false_hit",
                                  "wrong_primitive",
                                  "wrong_t",
                                  "wrong_uv",
                                  "undecidable",
                                  "unjudged",
                                  "unchecked",
                                  "wrong",
                                  "wrong_per_million",
                                  "left_out",
                                  "self_hit",
                                  "t_ulps",
                                  "ns_per_ray",
                                  "ns_per_ray_rounds",
                                  "barycentric_error",
                                  "normal_angle_degrees"})
            EXPECT_TRUE(camera.contains(field)) << field;
        EXPECT_EQ(camera["rays"], 1536);
        EXPECT_GT(camera["ns_per_ray"], 0);
        EXPECT_GT(method["total"]["rays"], 1536);
    }
    const std::string csv = text_of(folder + "/results.csv");
    EXPECT_EQ(csv.substr(0, 17), "method,kind,rays,");
    const std::string page = text_of(folder + "/index.html");
    EXPECT_NE(page.find("data:image/png;base64,"), std::string::npos);
    for (const char* outside : {"src=\"http", "href=\"http", "<link", "@import"})
        EXPECT_EQ(page.find(outside), std::string::npos) << outside;
    for (const auto& entry : fs::directory_iterator(folder))
        EXPECT_FALSE(entry.path().filename().string().starts_with(temporary_prefix))
            << entry.path();
}

TEST(CompareReport, NamesTheMachineAndTheCausesOfErrors) {
    const std::string folder = (test_folder() / "report").string();
    ASSERT_EQ(run_compare(table +
                          " --aim vertices,edges --aim-rays 2000 --rounds 1 --methods "
                          "plane-inside --max-wrong 1e6 --report " +
                          folder),
              0)
        << printed();
    const auto json = results_in(folder);
    for (const char* field : {"processor", "threads", "memory_bytes", "vectors"})
        EXPECT_TRUE(json["machine"].contains(field)) << field;
    std::set<std::string> causes;
    for (const auto& worst : json["worst"]) causes.insert(worst["cause"]);
    // Rays at edges are lost there, and nowhere else.
    EXPECT_TRUE(causes.contains("edge") || causes.contains("shared"));
    EXPECT_FALSE(causes.contains("other"));
    EXPECT_TRUE(causes.contains("largest_error"));
}

TEST(CompareReport, ExitsWith4IfTheRenderingEngineIsWrongTooOften) {
    const std::string rays = write_vertex_rays();
    const std::string command = table + " --rays " + rays +
                                " --rounds 1 --methods exact --report " +
                                (test_folder() / "report").string();
    EXPECT_EQ(run_compare(command + " --intersector exact --max-wrong 0"), 0) << printed();
    EXPECT_EQ(run_compare(command + " --intersector plane-inside --max-wrong 0"), 4);
    const auto json = results_in(test_folder() / "report");
    EXPECT_EQ(json["production"], "plane-inside");
    EXPECT_GT(json["methods"][0]["total"]["wrong"], 0);
    EXPECT_EQ(json["methods"][1]["total"]["wrong"], 0);
    EXPECT_GE(json["worst"].size(), 1u);
    EXPECT_EQ(run_compare(command + " --intersector plane-inside --max-wrong 1e6"), 0);
}

TEST(CompareReport, WorstRaysCanBeReplayedFromTheirLiterals) {
    const std::string rays = write_vertex_rays();
    const std::string folder = (test_folder() / "report").string();
    run_compare(table + " --rays " + rays + " --rounds 1 --methods plane-inside --report " +
                folder);
    const auto worst = results_in(folder)["worst"][0];
    const std::string literal = worst["ray"];
    EXPECT_EQ(run_compare(table + " --methods plane-inside --ray=" + literal), 0) << printed();
    EXPECT_NE(printed().find(literal), std::string::npos);
    const std::string verdict = worst["answers"][1]["verdict"];
    EXPECT_NE(printed().find("plane-inside             " + verdict), std::string::npos);
}

TEST(CompareReport, IsWrittenEvenWithoutHitsOrRays) {
    const std::string folder = (test_folder() / "report").string();
    EXPECT_EQ(run_compare(table + " --size 16x16 --rounds 1 --look-from 0,9,0 --look-at 0,99,1" +
                          " --report " + folder),
              0)
        << printed();
    const std::string path = (test_folder() / "none").string();
    write_rays(path, {}, load_gltf(table));
    EXPECT_EQ(run_compare(table + " --rays " + path + " --report " + folder), 0) << printed();
    EXPECT_EQ(results_in(folder)["rays"]["camera"], 0);
}

TEST(CompareReport, RejectsInvalidArguments) {
    const std::string report = " --report " + (test_folder() / "report").string();
    EXPECT_EQ(run_compare(table), 2);
    EXPECT_EQ(run_compare(table + " --methods nothing" + report), 2);
    EXPECT_NE(printed().find("baldwin-weber-double"), std::string::npos);
    EXPECT_EQ(run_compare(table + " --ray=1,2,3"), 2);
    EXPECT_EQ(run_compare(table + " --rays " + table + report), 1);
    EXPECT_EQ(run_compare(table + " --ray=nan,0,0,0,0,1,0,inf"), 0);
    EXPECT_NE(printed().find("truth    nothing"), std::string::npos);
    EXPECT_EQ(run_compare("nowhere.gltf" + report), 1);
}

}  // namespace
}  // namespace sightline
