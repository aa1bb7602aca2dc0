#pragma once
#include <nlohmann/json_fwd.hpp>

#include <array>
#include <string>

namespace sightline {

/// The files of a report besides its charts.
inline constexpr std::array<const char*, 3> report_files = {"index.html", "results.json",
                                                            "results.csv"};

/// Makes a folder if it does not exist. Throws Error.
void make_report_folder(const std::string& folder);

/// Claims the files of a report in `folder`, which is made if it does not exist. To be called
/// before any work. Throws Error as claim_outputs does.
void claim_report(const std::string& folder, bool overwrite);

/// Draws the charts of `folder`/results.json (chart-*.svg and .png) with the script tools/charts,
/// which needs python3 and matplotlib. Then writes `folder`/index.html: the page filled with the
/// data (see fill_page), with <!--CHARTS--> replaced by the charts or, if they cannot be drawn, by
/// a line on how to get them.
void write_report_page(const std::string& folder, std::string page,
                       const nlohmann::ordered_json& data);

}  // namespace sightline
