// Charts of a report, or the line that replaces them if they cannot be drawn.
#include "lab/charts.h"
#include "core/error.h"
#include "intersect/engines.h"
#include "lab/atlas/families.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>

namespace sightline {
namespace {

constexpr const char* results = R"({
  "version": "0.1.0", "scene": "ball $\\x$.glb", "max_wrong_per_million": 1, "rays": {"camera": 1000},
  "methods": [
    {"name": "embree",
     "kinds": {"camera": {"rays": 1000, "ns_per_ray": 50, "ns_per_ray_rounds": [49, 50, 51]}},
     "total": {"rays": 1000, "wrong": 3, "unjudged": 0, "ns_per_ray": 50,
               "wrong_per_million": {"estimate": 3000}}},
    {"name": "exact",
     "kinds": {"camera": {"rays": 1000, "ns_per_ray": 70, "ns_per_ray_rounds": [70, 70, 72]}},
     "total": {"rays": 1000, "wrong": 0, "unjudged": 0, "ns_per_ray": 70,
               "wrong_per_million": {"estimate": 0}}}]})";

/// The page written for these results.
std::string page_for(const std::string& text) {
    const auto folder = test_folder();
    write_report(folder.string(), {.results = text,
                                   .csv = "",
                                   .page = "<p>before</p><!--CHARTS--><p>after</p>/*DATA*/",
                                   .data = {}});
    std::ifstream page(folder / "index.html");
    return {std::istreambuf_iterator<char>(page), {}};
}

bool has_matplotlib() {
    return std::system("/usr/bin/python3 -c 'import matplotlib' 2> /dev/null") == 0;
}

/// Names in the test's folder.
std::set<std::string> names_in_folder() {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(test_folder()))
        names.insert(entry.path().filename().string());
    return names;
}

TEST(Charts, AreInTheReportAndInFilesOfTheirOwn) {
    if (!has_matplotlib()) GTEST_SKIP() << "python3-matplotlib is not installed";
    const std::string html = page_for(results);
    EXPECT_EQ(html.find("<p>before</p><figure class=\"chart\" id=\"chart-pareto\"><svg"), 0u);
    EXPECT_NE(html.find("embree"), std::string::npos);
    EXPECT_NE(html.find("</figure>\n<p>after</p>"), std::string::npos);
    EXPECT_NE(html.find("none wrong of 1,000"), std::string::npos);
    EXPECT_NE(html.find(">ball $\\x$.glb: all rays"), std::string::npos);
    EXPECT_EQ(html.find("mathdefault"), std::string::npos);
    for (const char* name : {"chart-pareto.svg", "chart-pareto.png", "chart-price.svg"})
        EXPECT_GT(std::filesystem::file_size(test_folder() / name), 1000u);
}

TEST(Charts, AreOfThePriceAloneWhereNothingErred) {
    if (!has_matplotlib()) GTEST_SKIP() << "python3-matplotlib is not installed";
    page_for(results);
    std::string right = results;
    right.replace(right.find("\"wrong\": 3"), 10, "\"wrong\": 0");
    const std::string html = page_for(right);
    EXPECT_EQ(html.find("<p>before</p><figure class=\"chart\" id=\"chart-price\"><svg"), 0u);
    // That of the report before is gone.
    EXPECT_EQ(names_in_folder(),
              (std::set<std::string>{".sightline", "chart-price.png", "chart-price.svg",
                                     "index.html", "results.csv", "results.json"}));
}

TEST(Charts, AreReplacedByAReasonIfTheyCannotBeDrawn) {
    for (const char* text : {"", "{}", "{\"methods\": []}"}) {
        const std::string html = page_for(text);
        EXPECT_EQ(html.find("<p>before</p><p>after</p>"), 0u);
        EXPECT_NE(html.find("\"no_charts\":\"/usr/bin/python3 "), std::string::npos) << html;
    }
}

TEST(Report, IsWholeOrThatOfBefore) {
    page_for(results);
    const auto folder = test_folder();
    std::filesystem::remove(folder / "results.csv");
    std::filesystem::create_directory(folder / "results.csv");  // cannot be replaced by a file
    const auto names = names_in_folder();
    EXPECT_THROW(
        write_report(folder.string(), {.results = "{}", .csv = "", .page = "", .data = {}}), Error);
    EXPECT_EQ(names_in_folder(), names);
    std::ifstream file(folder / "results.json");
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(text, std::string(results) + "\n");
    for (const auto& entry : std::filesystem::directory_iterator(folder / ".sightline"))
        EXPECT_EQ(entry.path().filename(), "outputs");  // the drawings are gone
}

TEST(Looks, AreGivenToEveryFamilyAndMethodAndNoColourTwice) {
    std::ifstream file(SIGHTLINE_SOURCE_DIR "/tools/charting/looks.json");
    const auto looks = nlohmann::json::parse(file);
    std::set<std::string> families, colors;
    for (const auto& question : looks["questions"])
        for (const auto& [name, title] : question["families"].items())
            EXPECT_TRUE(families.insert(name).second) << name;
    for (const auto& [name, look] : looks["methods"].items())
        EXPECT_TRUE(colors.insert(look[0]).second) << name;
    for (const Family& family : atlas_families()) {
        EXPECT_EQ(families.erase(family.name), 1u) << family.name;
        for (const std::string& method : family.methods) {
            const auto base = std::regex_replace(method, std::regex("-(double|single)$"), "");
            EXPECT_TRUE(looks["methods"].contains(method) || looks["methods"].contains(base))
                << method;
        }
    }
    EXPECT_TRUE(families.empty());
    for (const EngineEntry& engine : engine_registry())
        EXPECT_TRUE(looks["methods"].contains(
            std::regex_replace(engine.name, std::regex("-(double|single)$"), "")))
            << engine.name;
}

}  // namespace
}  // namespace sightline
