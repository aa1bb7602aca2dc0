#pragma once
#include <nlohmann/json_fwd.hpp>

#include <string>

namespace sightline {

/// Draws the charts of `folder`/results.json (chart-*.svg and .png) with the script tools/charts,
/// which needs python3 and matplotlib. Then writes `folder`/index.html: the page filled with the
/// data (see fill_page), with <!--CHARTS--> replaced by the charts or, if they cannot be drawn, by
/// a line on how to get them.
void write_report_page(const std::string& folder, std::string page,
                       const nlohmann::ordered_json& data);

}  // namespace sightline
