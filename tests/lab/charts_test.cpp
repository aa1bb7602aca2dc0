// Charts of a report, or the line that replaces them if they cannot be drawn.
#include "lab/charts.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace sightline {
namespace {

constexpr const char* results = R"({
  "version": "0.1.0", "scene": "ball.glb", "max_wrong_per_million": 1, "methods": [
    {"name": "embree",
     "kinds": {"camera": {"rays": 1000, "ns_per_ray": 50, "ns_per_ray_rounds": [49, 50, 51]}},
     "total": {"rays": 1000, "wrong": 3, "unjudged": 0,
               "wrong_per_million": {"estimate": 3000}}},
    {"name": "exact",
     "kinds": {"camera": {"rays": 1000, "ns_per_ray": 70, "ns_per_ray_rounds": [70, 70, 72]}},
     "total": {"rays": 1000, "wrong": 0, "unjudged": 0,
               "wrong_per_million": {"estimate": 0}}}]})";

/// The page written for these results.
std::string page_for(const std::string& text) {
    const auto folder = test_folder();
    std::ofstream(folder / "results.json") << text;
    write_report_page(folder.string(), "<p>before</p><!--CHARTS--><p>after</p>/*DATA*/", {});
    std::ifstream page(folder / "index.html");
    return {std::istreambuf_iterator<char>(page), {}};
}

TEST(Charts, AreInTheReportAndInFilesOfTheirOwn) {
    if (std::system("/usr/bin/python3 -c 'import matplotlib' 2> /dev/null") != 0)
        GTEST_SKIP() << "python3-matplotlib is not installed";
    const std::string html = page_for(results);
    EXPECT_EQ(html.find("<p>before</p><figure class=\"chart\"><svg"), 0u);
    EXPECT_NE(html.find("embree"), std::string::npos);
    EXPECT_NE(html.find("</figure>\n<p>after</p>"), std::string::npos);
    EXPECT_NE(html.find("none wrong of 1,000"), std::string::npos);
    for (const char* name : {"chart-pareto.svg", "chart-pareto.png"})
        EXPECT_GT(std::filesystem::file_size(test_folder() / name), 1000u);
}

TEST(Charts, AreReplacedByALineIfTheyCannotBeDrawn) {
    for (const char* text : {"", "{}", "{\"methods\": []}"})
        EXPECT_EQ(page_for(text).find("<p>before</p><p>The charts could not be drawn"), 0u);
}

}  // namespace
}  // namespace sightline
