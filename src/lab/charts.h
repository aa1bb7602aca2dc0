#pragma once
// Reports of the laboratory as files: measurements, a page and its charts.
#include <nlohmann/json.hpp>

#include <array>
#include <string>

namespace sightline {

/// The files of a report besides its charts.
inline constexpr std::array<const char*, 3> report_files = {"index.html", "results.json",
                                                            "results.csv"};

/// Claims the files of a report in `folder`, which is made if it does not exist. To be called
/// before any work. Throws Error as claim_outputs does.
void claim_report(const std::string& folder, bool overwrite);

struct Report {
    std::string results;  ///< results.json
    std::string csv;      ///< results.csv
    std::string page;     ///< index.html before it is filled
    /// Of the page. Added are `looks`, the looks of methods, and `no_charts`: "" or why none could
    /// be drawn.
    nlohmann::ordered_json data;
};

/// Writes the report's files and its charts (chart-*.svg and .png), which the script tools/charts
/// draws from the results: it needs python3 and matplotlib. All files are complete before the first
/// of them replaces an earlier one; the page comes last. It is the template filled with the data
/// (see fill_page), with <!--CHARTS--> replaced by the charts, each a figure with its file's name
/// as id. Why there are none is also printed. Throws Error.
void write_report(const std::string& folder, const Report& report);

}  // namespace sightline
